/* Step and direction of all axes; see steps.c. */
#ifndef STEPS_H
#define STEPS_H

#include "splineway.h"
#include <stdbool.h>

/* Setpoints per second. */
#define SERVO_HZ 1000
/* Ticks of the step timer per second: an axis makes a step in every other at most. */
#define STEP_HZ 100000
#define STEPS_PER_MM 400

/* The axes stand at these positions, nm. Before the timers run. */
void steps_start(const int64_t *positions);

/* Where the axes are to be at the end of the servo cycle that begins. From the servo interrupt. */
void steps_go(const splineway_setpoint *setpoint);

/* A tick of the step timer. From its interrupt, which is above the servo interrupt. */
void steps_tick(void);

/* Whether an axis had more steps to make in a servo cycle than there are ticks. */
bool steps_lagged(void);

#endif
