/* What STM32CubeMX would generate: the HAL, and the pins by name. */
#ifndef MAIN_H
#define MAIN_H

#include "stm32f4xx_hal.h"

#define STEP_GPIO_Port GPIOD
#define STEP_X_Pin GPIO_PIN_0
#define DIRECTION_X_Pin GPIO_PIN_1
#define STEP_Y_Pin GPIO_PIN_2
#define DIRECTION_Y_Pin GPIO_PIN_3
#define STEP_Z_Pin GPIO_PIN_4
#define DIRECTION_Z_Pin GPIO_PIN_7
#define ENABLE_GPIO_Port GPIOD
#define ENABLE_Pin GPIO_PIN_8
#define HOLD_BUTTON_GPIO_Port GPIOA
#define HOLD_BUTTON_Pin GPIO_PIN_0
#define STOP_BUTTON_GPIO_Port GPIOC
#define STOP_BUTTON_Pin GPIO_PIN_4

#endif
