/* The real-time core of Abbe for C: load a machine once, then correct one command per cycle.
 *
 *   abbe_rt_model* model = abbe_rt_load("machine.toml", "T1=23.4", NULL, 0);
 *   every cycle:  status = abbe_rt_correct(model, command, gauge_length, corrected, &step);
 *
 * abbe_rt_load reads files and allocates: call it before the control runs. abbe_rt_correct does neither, takes
 * no lock, throws nothing and does a fixed amount of work: a first-order step and one Newton step on the exact
 * model (docs/theory/correction.md). A model is never changed: threads may share it.
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
  ABBE_RT_HELD = 2     /* not corrected, `corrected` is the command: near a singular pose, a rotary correction
                          above 0.5 deg, a correction out of the travels, or numbers that are not finite. The
                          correction drops to zero: ramp it, as the example does */
} abbe_rt_status;

/* The version of the library: compare with ABBE_RT_VERSION of the header. */
int abbe_rt_version(void);

/* Reads a machine file. `sensors`: values of sensors and t, "T1=23.4,t=0", or NULL. Which axes correct is decided
 * as by `abbe correct`: three linear and up to two rotary ones.
 * errors  NULL, with the reasons in `message` (cut to `size` bytes, always ended; NULL: not wanted): what
 *         `abbe predict` says of the file, and machines that need the general model: errors of several axes, of
 *         the direction of approach or of velocities, fewer than three linear axes */
abbe_rt_model* abbe_rt_load(const char* machine_file, const char* sensors, char* message, size_t size);
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
 * last_step      (may be NULL) length of the last Newton step, mm, a radian counting 300 mm: what is left is a
 *                small part of it
 */
abbe_rt_status abbe_rt_correct(const abbe_rt_model* model, const double* commanded, double gauge_length,
                               double* corrected, double* last_step);

#ifdef __cplusplus
}
#endif

#endif
