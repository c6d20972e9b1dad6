//! Trained tensors, and the steps of Adam on them.
//!
//! Reference: Kingma, Ba, Adam: a method for stochastic optimization, ICLR 2015, algorithm 1, both corrections in one (end of sec. 2).

use burn_tensor::{Device, Gradients, Tensor, TensorData};

/// Decay rates of the moments, as the paper recommends.
const DECAY: [f32; 2] = [0.9, 0.999];
/// Guard against division by zero: far below the gradients of losses of order one.
const EPSILON: f32 = 1e-8;

/// A tensor that is trained, with the moments of its gradients once there were any.
#[derive(Debug)]
pub(super) struct Parameter<const D: usize> {
    value: Tensor<D>,
    moments: Option<[Tensor<D>; 2]>,
}

impl<const D: usize> Parameter<D> {
    /// Numbers in row-major order; on a device with autodiff their gradients are kept.
    pub(super) fn new(numbers: &[f32], shape: [usize; D], device: &Device) -> Parameter<D> {
        let value = Tensor::from_data(TensorData::new(numbers.to_vec(), shape), device);
        Parameter { value: if device.is_autodiff() { value.require_grad() } else { value }, moments: None }
    }

    pub(super) fn value(&self) -> Tensor<D> {
        self.value.clone()
    }

    /// The parameter after a step; as it is if the loss does not depend on it.
    pub(super) fn stepped(self, gradients: &mut Gradients, step: &Step) -> Parameter<D> {
        let Some(gradient) = self.value.grad_remove(gradients) else { return self };
        let parts = [gradient.clone(), gradient.square()];
        let moments = match self.moments {
            None => [0, 1].map(|i| parts[i].clone().mul_scalar(1.0 - DECAY[i])),
            Some(before) => {
                [0, 1].map(|i| before[i].clone().mul_scalar(DECAY[i]).add(parts[i].clone().mul_scalar(1.0 - DECAY[i])))
            }
        };
        let [first, second] = moments.clone();
        let towards = first
            .mul_scalar(step.second_correction / step.first_correction)
            .div(second.sqrt().add_scalar(EPSILON * step.second_correction));
        let value = self.value.inner() - towards.mul_scalar(step.rate);
        Parameter { value: value.autodiff().require_grad(), moments: Some(moments) }
    }
}

/// One step for all parameters.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    rate: f64,
    /// `1 - decay^number` of the first moment, and its square root of the second.
    first_correction: f32,
    second_correction: f32,
}

impl Step {
    /// Step `number`, from 1, of this learning rate.
    pub(super) fn new(number: usize, rate: f64) -> Step {
        let [first_correction, second] = DECAY.map(|decay| 1.0 - decay.powi(number as i32));
        Step { rate, first_correction, second_correction: second.sqrt() }
    }
}

#[cfg(test)]
#[path = "../../tests/units/adam.rs"]
mod tests;
