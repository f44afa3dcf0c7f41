#ifndef SPLINEWAY_EXAMPLE_H
#define SPLINEWAY_EXAMPLE_H

#include "splineway.h"

/* Called with every setpoint. */
typedef void (*example_drive)(const splineway_setpoint *setpoint);

/* Runs the example; 0, or the result that stopped it. */
int example_run(example_drive drive);

#endif
