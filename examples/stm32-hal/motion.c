/*
 * Motion on an STM32 with its HAL. Three contexts:
 *
 *   background   motion_poll(), called by the main loop: gives blocks and plans.
 *   TIM6         the servo cycle, an ordinary timer interrupt of the HAL: one setpoint, from which steps.c gets its targets.
 *   TIM7         the step timer, of a higher priority (a lower number) than TIM6: pulses. See steps.c.
 *
 * and the buttons' interrupts, of any priority, which give an operator's commands.
 *
 * In STM32CubeMX: TIM6 with a period of 1 / SERVO_HZ and TIM7 with one of 1 / STEP_HZ (steps.h), both with their interrupts on, but no
 * handler generated for TIM7; the pins of steps.c, ENABLE and the buttons under these names, both buttons with interrupts at both edges.
 * motion_start() goes to USER CODE BEGIN 2 of main.c, motion_poll() to its endless loop.
 */
#include "motion.h"
#include "main.h"
#include "steps.h"

extern TIM_HandleTypeDef htim6, htim7;

#define MM(x) ((int64_t)((x) * 1000000.0))

/* A program: X, Y, Z. One from a file or a line is pushed in the same way. */
static const int64_t program[][SPLINEWAY_AXES] = {
    {MM(20.0), MM(0.0), MM(0.0)},  {MM(20.0), MM(15.0), MM(0.0)}, {MM(15.0), MM(20.0), MM(1.0)},
    {MM(-5.0), MM(20.0), MM(1.0)}, {MM(0.0), MM(0.0), MM(0.0)},
};
#define BLOCKS (sizeof program / sizeof program[0])

/* Not on a stack, and nothing is allocated. */
static splineway_core core;
static uint32_t pushed;
static motion_fault fault;
static volatile bool stopped;

/* The emergency stop: the drives lose their enable at once, and with it the position; only a reset brings the machine back. */
static void stop(void)
{
    stopped = true;
    HAL_GPIO_WritePin(ENABLE_GPIO_Port, ENABLE_Pin, GPIO_PIN_RESET);
    splineway_abort(&core);
}

splineway_result motion_start(void)
{
    static const int64_t start[SPLINEWAY_AXES] = {0};
    splineway_config config;
    splineway_result result = splineway_config_init(&config, 100.0f, 1000.0f, 20000.0f);
    if (result != SPLINEWAY_RESULT_OK) {
        return result;
    }
    config.cycle = 1.0f / SERVO_HZ;
    /* Longer than a planning step takes. */
    config.lead = 0.05f;
    result = splineway_init(&core, sizeof core, &config, start);
    if (result != SPLINEWAY_RESULT_OK) {
        return result;
    }
    steps_start(start);
    if (HAL_TIM_Base_Start_IT(&htim7) != HAL_OK || HAL_TIM_Base_Start_IT(&htim6) != HAL_OK) {
        return SPLINEWAY_RESULT_NOT_READY;
    }
    /* The stop button is normally closed to ground: open - pressed, or a broken wire - is high. It is asked behind this, so that one
       which comes in between counts. */
    HAL_GPIO_WritePin(ENABLE_GPIO_Port, ENABLE_Pin, GPIO_PIN_SET);
    if (stopped || HAL_GPIO_ReadPin(STOP_BUTTON_GPIO_Port, STOP_BUTTON_Pin) == GPIO_PIN_SET) {
        stop();
    }
    /* Neither does a hold that is pressed already give an edge. */
    if (HAL_GPIO_ReadPin(HOLD_BUTTON_GPIO_Port, HOLD_BUTTON_Pin) == GPIO_PIN_SET) {
        splineway_hold(&core);
    }
    return SPLINEWAY_RESULT_OK;
}

bool motion_poll(void)
{
    splineway_block options = {.feed = 50.0f, .duration = 0.0f, .tolerance = -1.0f, .exact_stop = false, .tag = 0};
    while (pushed < BLOCKS) {
        options.tag = pushed + 1;
        const splineway_result result = splineway_push_line(&core, program[pushed], &options);
        if (result != SPLINEWAY_RESULT_OK) {
            if (result != SPLINEWAY_RESULT_FULL && fault.result == SPLINEWAY_RESULT_OK) {
                /* Refused, or ABORTED: the rest must not be run from where the machine stands. */
                fault.result = result;
                fault.block = options.tag;
            }
            break;
        }
        ++pushed;
    }
    if (pushed == BLOCKS || fault.result != SPLINEWAY_RESULT_OK) {
        splineway_finish(&core);
    }
    if (steps_lagged() && fault.result == SPLINEWAY_RESULT_OK) {
        /* More steps than the timer can make: STEP_HZ, STEPS_PER_MM and the velocity do not fit. */
        splineway_abort(&core);
        fault.result = SPLINEWAY_RESULT_CONFIG;
    }
    return splineway_poll(&core) == SPLINEWAY_PROGRESS_DONE;
}

motion_fault motion_what_is_wrong(void)
{
    return fault;
}

/* The servo interrupt. */
void HAL_TIM_PeriodElapsedCallback(TIM_HandleTypeDef *timer)
{
    splineway_setpoint setpoint;
    if (timer->Instance == TIM6 && splineway_tick(&core, &setpoint) == SPLINEWAY_RESULT_OK) {
        steps_go(&setpoint);
    }
}

/* The step timer: by itself, as the HAL's handler takes longer than the work. */
void TIM7_IRQHandler(void)
{
    __HAL_TIM_CLEAR_IT(&htim7, TIM_IT_UPDATE);
    steps_tick();
}

/* Other interrupts: commands may come from any. */
void HAL_GPIO_EXTI_Callback(uint16_t pin)
{
    if (pin == STOP_BUTTON_Pin) {
        stop();
    } else if (pin == HOLD_BUTTON_Pin) {
        if (HAL_GPIO_ReadPin(HOLD_BUTTON_GPIO_Port, HOLD_BUTTON_Pin) == GPIO_PIN_SET) {
            splineway_hold(&core);
        } else {
            splineway_resume(&core);
        }
    }
}
