/* The stub's hardware. */
#include "main.h"

TIM_TypeDef stub_timer[2];
GPIO_TypeDef stub_port[3];
TIM_HandleTypeDef htim6 = {TIM6}, htim7 = {TIM7};

HAL_StatusTypeDef HAL_TIM_Base_Start_IT(TIM_HandleTypeDef *htim)
{
    htim->Instance->DIER |= TIM_IT_UPDATE;
    htim->Instance->CR1 |= 1;
    return HAL_OK;
}

GPIO_PinState HAL_GPIO_ReadPin(GPIO_TypeDef *GPIOx, uint16_t GPIO_Pin)
{
    return (GPIOx->IDR & GPIO_Pin) != 0 ? GPIO_PIN_SET : GPIO_PIN_RESET;
}

void HAL_GPIO_WritePin(GPIO_TypeDef *GPIOx, uint16_t GPIO_Pin, GPIO_PinState PinState)
{
    /* A store to BSRR acts at once. */
    GPIOx->ODR = PinState == GPIO_PIN_SET ? GPIOx->ODR | GPIO_Pin : GPIOx->ODR & ~(uint32_t)GPIO_Pin;
}
