/* Motion of three axes; see motion.c. */
#ifndef MOTION_H
#define MOTION_H

#include "splineway.h"
#include <stdbool.h>

/* What has gone wrong: the result of the call, and the block. */
typedef struct {
    splineway_result result;
    uint32_t block;
} motion_fault;

/* Sets the core up and starts the timers. Anything but OK: nothing moves. */
splineway_result motion_start(void);

/* A slice of planning: to be called by the main loop, again and again. True: all has been run. */
bool motion_poll(void);

/* What has gone wrong, if it has: `result` is OK otherwise. For the main loop. */
motion_fault motion_what_is_wrong(void);

#endif
