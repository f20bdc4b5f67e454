/* Corrects a path in real time, as a servo task would: no allocation, no locks, fixed work per cycle.
 *
 *   real_time MACHINE.toml
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "abbe/rt/abbe_rt.h"

#define AXES 16
#define CYCLE 0.001 /* s */

/* The correction may change by this much per cycle: mm and rad. When a pose cannot be corrected, its correction
 * goes to zero; the machine must get there on a ramp and not in one jump. */
#define SLEW_LINEAR (0.5 * CYCLE)
#define SLEW_ROTARY (0.001 * CYCLE)

struct task {
  const abbe_rt_model *model;
  int axes;
  double correction[AXES]; /* in force */
};

static double limited(double from, double to, double step) {
  if (to > from + step) return from + step;
  if (to < from - step) return from - step;
  return to;
}

/* One cycle: the command in, what the drives get out. */
static abbe_rt_status cycle(struct task *task, const double *command, double gauge_length, double *drives) {
  double wanted[AXES];
  const abbe_rt_status status = abbe_rt_correct(task->model, command, gauge_length, wanted, NULL);
  int i;
  for (i = 0; i < task->axes; ++i) {
    const double step = abbe_rt_is_rotary(task->model, i) ? SLEW_ROTARY : SLEW_LINEAR;
    task->correction[i] = limited(task->correction[i], wanted[i] - command[i], step);
    drives[i] = command[i] + task->correction[i];
  }
  return status;
}

int main(int argc, char **argv) {
  char message[2000];
  abbe_rt_model *model;
  struct task task;
  double command[AXES] = {0}, drives[AXES];
  int i, k;

  if (argc != 2) {
    fprintf(stderr, "real_time: one argument, a machine file\n");
    return 2;
  }
  if (abbe_rt_version() != ABBE_RT_VERSION) {
    fprintf(stderr, "real_time: built for another version of the library\n");
    return 2;
  }
  model = abbe_rt_load(argv[1], NULL, message, sizeof message);
  if (model == NULL) {
    fprintf(stderr, "real_time: %s\n", message);
    return 2;
  }
  memset(&task, 0, sizeof task);
  task.model = model;
  task.axes = abbe_rt_axis_count(model);

  /* A slow start at one place, then a line: 2 s of cycles, every 200th printed. */
  printf("%8s", "ms");
  for (k = 0; k < task.axes; ++k)
    printf("%10s %8s", abbe_rt_axis_name(model, k), abbe_rt_is_rotary(model, k) ? "urad" : "um");
  printf("  status\n");
  for (i = 0; i <= 2000; ++i) {
    const double t = i < 1000 ? 0 : (i - 1000) * CYCLE;
    abbe_rt_status status;
    for (k = 0; k < task.axes; ++k) command[k] = abbe_rt_is_rotary(model, k) ? 0.3 + 0.1 * t : 20 + 60 * t;
    status = cycle(&task, command, abbe_rt_gauge_length(model), drives);
    if (i % 200 != 0) continue;
    printf("%8d", i);
    for (k = 0; k < task.axes; ++k) printf("%10.4f %8.2f", command[k], 1e3 * (abbe_rt_is_rotary(model, k) ? 1e3 : 1) * task.correction[k]);
    printf("  %s\n", status == ABBE_RT_OK ? "ok" : status == ABBE_RT_OUTSIDE ? "outside" : "held");
  }
  abbe_rt_free(model);
  return 0;
}
