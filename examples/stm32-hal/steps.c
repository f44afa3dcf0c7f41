/*
 * Step and direction. The steps of a servo cycle are spread evenly over the next one, by an error that is carried as in Bresenham's
 * lines. An axis knows how many steps it has made, not how many it should have: so a servo cycle that is a tick longer or shorter than
 * others loses none.
 *
 * Ticks of a servo cycle: 0 sets the directions, 1 is their set-up time, pulses begin with even ticks from 2 on and end with
 * odd ones. At 100 kHz: pulse and pause 10 us, set-up 20 us, hold 10 us.
 */
#include "steps.h"
#include "main.h"

/* Pulses that have room in a servo cycle. */
#define ROOM (STEP_HZ / SERVO_HZ / 2 - 1)

/* All on one port, so that a tick is one store. */
#define PORT STEP_GPIO_Port
static const uint16_t step_pin[SPLINEWAY_AXES] = {STEP_X_Pin, STEP_Y_Pin, STEP_Z_Pin};
static const uint16_t direction_pin[SPLINEWAY_AXES] = {DIRECTION_X_Pin, DIRECTION_Y_Pin, DIRECTION_Z_Pin};
#define ALL_STEPS (STEP_X_Pin | STEP_Y_Pin | STEP_Z_Pin)

/* Of the servo interrupt. */
static int64_t counted[SPLINEWAY_AXES], shift[SPLINEWAY_AXES];
/* From it to the step timer, which interrupts it: written while `fresh` is false. */
static volatile int64_t target[SPLINEWAY_AXES];
static volatile bool fresh, lagged;
/* Of the step timer. */
static struct {
    int64_t at;
    int32_t steps, error, way;
} axes[SPLINEWAY_AXES];
static uint32_t tick;

/* nm to steps, to the nearest. */
static int64_t to_steps(int64_t nm)
{
    const int64_t parts = nm * STEPS_PER_MM + 500000;
    const int64_t steps = parts / 1000000;
    return steps - (parts % 1000000 < 0);
}

void steps_start(const int64_t *positions)
{
    for (int axis = 0; axis < SPLINEWAY_AXES; ++axis) {
        axes[axis].at = counted[axis] = to_steps(positions[axis]);
    }
}

void steps_go(const splineway_setpoint *setpoint)
{
    /* As long as it is set, the step timer may read them. */
    fresh = false;
    for (int axis = 0; axis < SPLINEWAY_AXES; ++axis) {
        const int64_t steps = to_steps(setpoint->position[axis]);
        if (setpoint->activity == SPLINEWAY_ACTIVITY_SET) {
            /* Other coordinates, but the machine has not moved. */
            shift[axis] = counted[axis] - steps;
        }
        counted[axis] = steps + shift[axis];
        target[axis] = counted[axis];
    }
    fresh = true;
}

void steps_tick(void)
{
    uint32_t up = 0, down = 0;
    if (fresh) {
        fresh = false;
        tick = 0;
        down = ALL_STEPS;
        for (int axis = 0; axis < SPLINEWAY_AXES; ++axis) {
            const int64_t left = target[axis] - axes[axis].at;
            const int64_t steps = left < 0 ? -left : left;
            axes[axis].way = left < 0 ? -1 : 1;
            lagged = lagged || steps > ROOM;
            axes[axis].steps = steps > ROOM ? ROOM : (int32_t)steps;
            axes[axis].error = ROOM / 2;
            if (left < 0) {
                down |= direction_pin[axis];
            } else if (left > 0) {
                up |= direction_pin[axis];
            }
        }
    } else if (++tick % 2 == 1) {
        down = ALL_STEPS;
    } else if (tick / 2 <= ROOM) {
        for (int axis = 0; axis < SPLINEWAY_AXES; ++axis) {
            axes[axis].error += axes[axis].steps;
            if (axes[axis].error >= ROOM) {
                axes[axis].error -= ROOM;
                axes[axis].at += axes[axis].way;
                up |= step_pin[axis];
            }
        }
    }
    PORT->BSRR = up | down << 16;
}

bool steps_lagged(void)
{
    return lagged;
}
