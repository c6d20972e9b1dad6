//! Fast evaluation of a network, without allocation of memory and with the SIMD instructions of the machine.

use super::prepared::Prepared;
use finray_numerics::dense::{Weights, tanh};
use pulp::{Arch, Scalar, Simd, WithSimd};

/// Instruction set that evaluates a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instructions {
    /// The best instructions of the machine, detected at run time.
    Detected,
    /// Instructions that every machine supports.
    Portable,
}

/// A prepared network in the order in which its evaluation reads it, with buffers between its layers.
///
/// The inputs of the network are z = P x + offset for displacements x. The first hidden layer starts from h = z, and each hidden layer replaces h by
/// tanh(W h + b). The last layer gives the forces f = W h + b + skip z.
#[derive(Debug, Clone)]
pub(super) struct Forward {
    /// Detected instructions of the machine. `None` selects portable instructions.
    arch: Option<Arch>,
    coordinates: usize,
    projection: Weights<f64>,
    offset: Vec<f64>,
    /// Weights and bias of each layer.
    layers: Vec<(Weights<f32>, Vec<f32>)>,
    skip: Option<Weights<f32>>,
    projected: Vec<f64>,
    inputs: Vec<f32>,
    activations: [Vec<f32>; 2],
}

impl Forward {
    pub(super) fn new(prepared: &Prepared, instructions: Instructions) -> Forward {
        let Prepared { projection, offset, layers, skip } = prepared;
        let (inputs, coordinates) = projection.shape();
        let widest = layers.iter().map(|layer| layer.outputs).max().unwrap_or(0);
        let weights = |outputs: usize, inputs: usize, by_rows: &[f32]| {
            Weights::new(outputs, inputs, |output, input| by_rows[output * inputs + input])
        };
        let layer = |it: &super::Dense| (weights(it.outputs, it.inputs, &it.weights), it.bias.clone());
        Forward {
            arch: (instructions == Instructions::Detected).then(Arch::new),
            coordinates,
            projection: Weights::new(inputs, coordinates, |row, column| projection[(row, column)]),
            offset: offset.clone(),
            layers: layers.iter().map(layer).collect(),
            skip: (!skip.is_empty()).then(|| weights(prepared.outputs(), inputs, skip)),
            projected: vec![0.0; inputs],
            inputs: vec![0.0; inputs],
            activations: [(); 2].map(|()| vec![0.0; widest]),
        }
    }

    /// Number of displacement coordinates of a frame.
    pub(super) fn coordinates(&self) -> usize {
        self.coordinates
    }

    /// Forces of one frame, N, from its displacements, mm. The lengths of `displacements` and `forces_n` must fit the network.
    pub(super) fn forces(&mut self, displacements: &[f64], forces_n: &mut [f64]) {
        let (arch, evaluate) = (self.arch, Evaluate { network: self, displacements, forces_n });
        match arch {
            Some(arch) => arch.dispatch(evaluate),
            None => evaluate.with_simd(Scalar),
        }
    }
}

struct Evaluate<'a> {
    network: &'a mut Forward,
    displacements: &'a [f64],
    forces_n: &'a mut [f64],
}

impl WithSimd for Evaluate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Forward { projection, offset, layers, skip, projected, inputs: z, activations, .. } = self.network;
        projected.copy_from_slice(offset);
        projection.add_product(simd, self.displacements, projected);
        for (z, projected) in z.iter_mut().zip(&*projected) {
            *z = *projected as f32;
        }
        let [from, to] = activations;
        let (mut from, mut to) = (from.as_mut_slice(), to.as_mut_slice());
        for (k, (weights, bias)) in layers.iter().enumerate() {
            let y = &mut to[..bias.len()];
            y.copy_from_slice(bias);
            weights.add_product(simd, if k == 0 { z } else { from }, y);
            if k + 1 < layers.len() {
                tanh(simd, y);
            } else if let Some(skip) = skip {
                skip.add_product(simd, z, y);
            }
            std::mem::swap(&mut from, &mut to);
        }
        for (force_n, y) in self.forces_n.iter_mut().zip(&*from) {
            *force_n = f64::from(*y);
        }
    }
}
