//! Trained tensors, and the steps by which the optimiser Adam changes them.
//!
//! Reference: Kingma, Ba, Adam: a method for stochastic optimization, ICLR 2015, algorithm 1, with both bias corrections combined (end of sec. 2).

use super::TrainError;
use burn_tensor::{Device, Gradients, Tensor, TensorData};

/// Decay rates of the two moments, as recommended in the paper.
const DECAY: [f32; 2] = [0.9, 0.999];
/// Added to the denominator of a step to prevent division by zero. If the loss is of order one, gradients are far larger than this number.
const EPSILON: f32 = 1e-8;

/// A trained tensor, its numbers in row-major order, and the two moments of its gradients.
#[derive(Debug)]
pub(super) struct Parameter<const D: usize> {
    value: Tensor<D>,
    numbers: Vec<f32>,
    moments: [Vec<f32>; 2],
}

impl<const D: usize> Parameter<D> {
    /// A parameter with the given numbers; its gradients are recorded if the device has automatic differentiation.
    pub(super) fn new(numbers: &[f32], shape: [usize; D], device: &Device) -> Parameter<D> {
        let moments = [0, 1].map(|_| vec![0.0; numbers.len()]);
        Parameter { value: tracked(numbers.to_vec(), shape, device), numbers: numbers.to_vec(), moments }
    }

    pub(super) fn value(&self) -> Tensor<D> {
        self.value.clone()
    }

    /// Makes one step of Adam. Leaves the parameter unchanged if the loss does not depend on it.
    pub(super) fn step(&mut self, gradients: &mut Gradients, step: &Step) -> Result<(), TrainError> {
        let Some(gradient) = self.value.grad_remove(gradients) else { return Ok(()) };
        let [first, second] = &mut self.moments;
        let moments = first.iter_mut().zip(second);
        // The loop runs over plain numbers, because with tensors each of its twelve operations would be a separate pass over the data.
        for ((number, (first, second)), gradient) in self.numbers.iter_mut().zip(moments).zip(numbers(gradient)?) {
            *first = *first * DECAY[0] + gradient * (1.0 - DECAY[0]);
            *second = *second * DECAY[1] + gradient * gradient * (1.0 - DECAY[1]);
            let towards = *first * (step.second_correction / step.first_correction)
                / (second.sqrt() + EPSILON * step.second_correction);
            *number -= towards * step.rate;
        }
        self.value = tracked(self.numbers.clone(), self.value.dims(), &self.value.device());
        Ok(())
    }
}

/// A tensor with the given numbers; its gradients are recorded if the device has automatic differentiation.
fn tracked<const D: usize>(numbers: Vec<f32>, shape: [usize; D], device: &Device) -> Tensor<D> {
    let tensor = Tensor::from_data(TensorData::new(numbers, shape), device);
    if device.is_autodiff() { tensor.require_grad() } else { tensor }
}

/// Numbers of a tensor in row-major order.
///
/// # Errors
/// [`TrainError::Backend`] if the library cannot read the tensor.
pub(super) fn numbers<const D: usize>(tensor: Tensor<D>) -> Result<Vec<f32>, TrainError> {
    let data = tensor.try_into_data().map_err(|error| TrainError::Backend(format!("{error:?}")))?;
    data.try_into_vec::<f32>().map_err(|error| TrainError::Backend(format!("{error:?}")))
}

/// Step size and bias corrections of one step for all parameters.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    rate: f32,
    /// Bias correction of the first moment, 1 - decay^n in step n. `second_correction` is the square root of the bias correction of the second
    /// moment.
    first_correction: f32,
    second_correction: f32,
}

impl Step {
    /// Step number `number`, counted from 1, with the learning rate `rate`, dimensionless.
    pub(super) fn new(number: usize, rate: f64) -> Step {
        let [first_correction, second] = DECAY.map(|decay| 1.0 - decay.powi(number as i32));
        Step { rate: rate as f32, first_correction, second_correction: second.sqrt() }
    }
}

#[cfg(test)]
#[path = "../../tests/units/adam.rs"]
mod tests;
