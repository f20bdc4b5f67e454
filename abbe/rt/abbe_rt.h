/* The real-time core of Abbe for C: load a machine once, then correct one command per cycle.
 *
 *   abbe_rt_model* model = abbe_rt_load("machine.toml", "T1=23.4", 0, NULL, 0);
 *   every cycle:  status = abbe_rt_correct(model, command, gauge_length, corrected, &step);
 *
 * abbe_rt_load reads files and allocates: call it before the control runs. abbe_rt_correct does neither,
 * takes no lock, throws nothing and does a fixed amount of work: a first-order step and one Newton step on
 * the exact model (docs/theory/correction.md). A model is never changed: threads may share it.
 *
 * Positions: mm and rad, one number per moving axis in the order of abbe_rt_axis_name.
 * Version: functions and meanings of a version stay; ABBE_RT_VERSION grows when something is added.
 */
#ifndef ABBE_RT_H
#define ABBE_RT_H

#include <stddef.h>

#define ABBE_RT_VERSION 1

#ifdef __cplusplus
extern "C" {
#endif

typedef struct abbe_rt_model abbe_rt_model;

typedef enum abbe_rt_status {
  ABBE_RT_OK = 0,      /* corrected */
  ABBE_RT_OUTSIDE = 1, /* corrected, but an error was held beyond its measured ends */
  ABBE_RT_HELD = 2,    /* not corrected, `corrected` is the command: near a singular pose, a rotary correction
                          above 0.5 deg, a linear one above the limit, or a correction out of the travels. The
                          correction drops to zero: fade all of it with one factor, as the example does. Axes
                          must    not fade one by one, since a rotary correction and the linear ones that go with it
                          belong together */
  ABBE_RT_INVALID = 3  /* a command or the gauge length is not a finite number: `corrected` is not written */
} abbe_rt_status;

/* The version of the library: at least ABBE_RT_VERSION of the header it is used with. The functions below
 * need a model: NULL is not one. */
int abbe_rt_version(void);

/* Reads a machine file. `sensors`: values of sensors and t, "T1=23.4,t=0", or NULL. `max_correction`: a
 * larger correction of a linear axis, mm, is held, for it is more likely a wrong unit than an error; 0 stands
 * for 0.5. Which axes correct is decided as by `abbe correct`: three linear and up to two rotary ones, of 16
 * at most. Warnings and the calibration's dates are not looked at: `abbe describe` and `abbe check` do.
 * errors  NULL, with the reasons in `message` (cut to `size` bytes, always ended; NULL: not wanted): what
 *         `abbe predict` says of the file, and machines that need the general model: errors of several axes
 * or of velocities, fewer than three linear axes Errors that depend on the direction of approach count with
 * the mean of both. */
abbe_rt_model* abbe_rt_load(const char* machine_file, const char* sensors, double max_correction,
                            char* message, size_t size);
void abbe_rt_free(abbe_rt_model* model);

int abbe_rt_axis_count(const abbe_rt_model* model);
/* Name of an axis, or NULL; owned by the model. */
const char* abbe_rt_axis_name(const abbe_rt_model* model, int axis);
int abbe_rt_is_rotary(const abbe_rt_model* model, int axis);
/* The gauge length of the machine file, mm. */
double abbe_rt_gauge_length(const abbe_rt_model* model);

/* commanded      one number per axis, mm and rad
 * gauge_length   of the tool in the spindle, mm
 * corrected      what to command instead; may be the same array as `commanded`
 * A command outside the travels may stay there; a change of the gauge length changes the correction at once.
 * last_step      (may be NULL) length of the last Newton step, mm, a radian counting 300 mm: what is left is
 * a small part of it
 */
abbe_rt_status abbe_rt_correct(const abbe_rt_model* model, const double* commanded, double gauge_length,
                               double* corrected, double* last_step);

#ifdef __cplusplus
}
#endif

#endif
