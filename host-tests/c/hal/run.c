/*
 * The example on a host: both timers by turns as on a chip, pins looked at behind every tick of the step timer. Everything is counted from
 * the pins: where the axes are, pulses that are no longer or shorter than a tick, directions that change too near to a step.
 */
#include "main.h"
#include "motion.h"
#include "steps.h"
#include <stdio.h>
#include <stdlib.h>

extern TIM_HandleTypeDef htim6;
void TIM7_IRQHandler(void);

static const uint16_t step[3] = {STEP_X_Pin, STEP_Y_Pin, STEP_Z_Pin};
static const uint16_t direction[3] = {DIRECTION_X_Pin, DIRECTION_Y_Pin, DIRECTION_Z_Pin};
static long at[3], most[3], edges;
static int broken, turned[3], pulse[3];

/* A tick of the step timer. */
static void tick(void)
{
    const uint32_t before = GPIOD->ODR;
    GPIOD->BSRR = 0;
    TIM7_IRQHandler();
    const uint32_t set = GPIOD->BSRR;
    GPIOD->ODR = (before & ~(set >> 16)) | (set & 0xFFFF);
    broken += (set & set >> 16) != 0;
    for (int axis = 0; axis < 3; ++axis) {
        const uint32_t changed = before ^ GPIOD->ODR;
        turned[axis] = (changed & direction[axis]) != 0 ? 0 : turned[axis] + 1;
        pulse[axis] = (changed & step[axis]) != 0 ? 1 : pulse[axis] + 1;
        if ((changed & step[axis]) != 0 && (GPIOD->ODR & step[axis]) != 0) {
            at[axis] += (GPIOD->ODR & direction[axis]) != 0 ? 1 : -1;
            most[axis] = at[axis] > most[axis] ? at[axis] : most[axis];
            broken += turned[axis] < 2 || (GPIOD->ODR & ENABLE_Pin) == 0;
            ++edges;
        }
        broken += (GPIOD->ODR & step[axis]) != 0 && pulse[axis] > 1;
    }
}

/* Servo cycles until all has been run and nothing moves, or so many. `jitter`: the servo cycle is a tick longer or shorter. */
static int cycles(int count, bool jitter)
{
    for (int cycle = 0; cycle < count; ++cycle) {
        const long before = edges;
        bool done = false;
        for (int poll = 0; poll < 50; ++poll) {
            done = motion_poll();
        }
        HAL_TIM_PeriodElapsedCallback(&htim6);
        for (int n = STEP_HZ / SERVO_HZ + (jitter ? cycle % 3 - 1 : 0); n > 0; --n) {
            tick();
        }
        if (done && edges == before) {
            return cycle;
        }
    }
    return count;
}

int main(void)
{
    int ran, held, failures = 0;

    failures += motion_start() != SPLINEWAY_RESULT_OK || (GPIOD->ODR & ENABLE_Pin) == 0;
    failures += stub_timer[0].CR1 != 1 || stub_timer[1].CR1 != 1;
    cycles(300, false);
    /* Hold, for as long as it takes and longer. */
    GPIOA->IDR = HOLD_BUTTON_Pin;
    HAL_GPIO_EXTI_Callback(HOLD_BUTTON_Pin);
    cycles(400, false);
    held = (int)edges;
    cycles(100, false);
    failures += held == 0 || held != edges;
    GPIOA->IDR = 0;
    HAL_GPIO_EXTI_Callback(HOLD_BUTTON_Pin);
    ran = cycles(100000, true);
    failures += ran == 100000 || motion_what_is_wrong().result != SPLINEWAY_RESULT_OK || steps_lagged();
    /* Corners are rounded within 0.01 mm: 4 steps. */
    failures += labs(most[0] - 20 * STEPS_PER_MM) > 4 || labs(most[1] - 20 * STEPS_PER_MM) > 4;
    failures += labs(most[2] - 1 * STEPS_PER_MM) > 4;
    failures += at[0] != 0 || at[1] != 0 || at[2] != 0;
    printf("%ld steps, X%ld Y%ld Z%ld at the end, %d edges too near, ", edges, at[0], at[1], at[2], broken);
    /* The emergency stop. */
    GPIOC->IDR = STOP_BUTTON_Pin;
    HAL_GPIO_EXTI_Callback(STOP_BUTTON_Pin);
    failures += (GPIOD->ODR & ENABLE_Pin) != 0;
    printf("%d wrong\n", failures);
    return failures + broken != 0;
}
