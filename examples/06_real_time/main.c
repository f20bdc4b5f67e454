/* Corrects a path in real time, as a servo task would: no allocation, no locks, fixed work per cycle.
 *
 *   real_time MACHINE.toml
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "abbe/rt/abbe_rt.h"

#define AXES 16
#define CYCLE 0.001 /* s */

/* All corrections fade in and out together, by this share per cycle. A rotary correction and the linear ones
 * that make up for it belong together: axes that faded one by one would move the tip away from both. */
#define FADE (4 * CYCLE)
/* From one cycle to the next a correction changes by less than this, mm and rad; a larger change is a new
 * pose of the machine (a pole was crossed, another tool was taken) and is faded over to. */
#define CONTINUOUS 0.002

struct task {
  const abbe_rt_model* model;
  int axes;
  double correction[AXES]; /* the last one that was good */
  double share;            /* of it that is in force, 0 to 1 */
};

/* One cycle: the command in, what the drives get out. 0: the command is no command, nothing was written. */
static int cycle(struct task* task, const double* command, double gauge_length, double* drives,
                 abbe_rt_status* status) {
  double wanted[AXES];
  int i, follows;
  *status = abbe_rt_correct(task->model, command, gauge_length, wanted, NULL);
  if (*status == ABBE_RT_INVALID) return 0;
  follows = *status != ABBE_RT_HELD;
  for (i = 0; follows && task->share > 0 && i < task->axes; ++i)
    follows = fabs(wanted[i] - command[i] - task->correction[i]) <= CONTINUOUS;
  if (follows) {
    for (i = 0; i < task->axes; ++i) task->correction[i] = wanted[i] - command[i];
    task->share = task->share + FADE < 1 ? task->share + FADE : 1;
  } else {
    task->share = task->share - FADE > 0 ? task->share - FADE : 0;
  }
  for (i = 0; i < task->axes; ++i) drives[i] = command[i] + task->share * task->correction[i];
  return 1;
}

int main(int argc, char** argv) {
  char message[2000];
  abbe_rt_model* model;
  struct task task;
  double command[AXES] = {0}, drives[AXES];
  int i, k;

  if (argc != 2) {
    fprintf(stderr, "real_time: one argument, a machine file\n");
    return 2;
  }
  if (abbe_rt_version() < ABBE_RT_VERSION) {
    fprintf(stderr, "real_time: built for a newer version of the library\n");
    return 2;
  }
  model = abbe_rt_load(argv[1], NULL, 0, message, sizeof message);
  if (model == NULL) {
    fprintf(stderr, "real_time: %s\n", message);
    return 2;
  }
  memset(&task, 0, sizeof task);
  task.model = model;
  task.axes = abbe_rt_axis_count(model);

  /* A start at one place, then a line: 2 s of cycles, every 200th printed. */
  printf("%8s", "ms");
  for (k = 0; k < task.axes; ++k)
    printf("%10s %8s", abbe_rt_axis_name(model, k), abbe_rt_is_rotary(model, k) ? "urad" : "um");
  printf("  status\n");
  for (i = 0; i <= 2000; ++i) {
    const double t = i < 1000 ? 0 : (i - 1000) * CYCLE;
    abbe_rt_status status;
    for (k = 0; k < task.axes; ++k) command[k] = abbe_rt_is_rotary(model, k) ? 0.3 + 0.1 * t : 20 + 60 * t;
    if (!cycle(&task, command, abbe_rt_gauge_length(model), drives, &status)) {
      fprintf(stderr, "real_time: the command is not a number: a control stops here\n");
      return 1;
    }
    if (i % 200 != 0) continue;
    printf("%8d", i);
    for (k = 0; k < task.axes; ++k)
      printf("%10.4f %8.2f", command[k],
             (abbe_rt_is_rotary(model, k) ? 1e6 : 1e3) * (drives[k] - command[k]));
    printf("  %s, %3.0f %%\n",
           status == ABBE_RT_HELD      ? "held"
           : status == ABBE_RT_OUTSIDE ? "outside"
                                       : "ok",
           100 * task.share);
  }
  abbe_rt_free(model);
  return 0;
}
