//! Fast evaluation of a network, without allocation of memory and with the SIMD instructions of the machine.

use super::prepared::Prepared;
use finray_numerics::dense::{Aligned, Linear, Tanh, Weights, padded};
use pulp::{Arch, Scalar, Simd, WithSimd};

/// Instruction set that evaluates a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instructions {
    /// The best instructions of the machine, detected at run time.
    Detected,
    /// Instructions that every machine supports.
    Portable,
}

/// A prepared network, stored in the order in which the SIMD kernels read it, with buffers between its layers.
#[derive(Debug, Clone)]
pub(super) struct Forward {
    /// Detected instructions of the machine. `None` selects portable instructions.
    arch: Option<Arch>,
    plan: Plan,
    between: Between,
}

/// Weights of all layers. The inputs of the network are z = P x + offset for displacements x. The first hidden layer starts from h = z, and each
/// hidden layer replaces h by tanh(W h + b). The last layer gives the forces f = W h + b + skip z.
#[derive(Debug, Clone)]
struct Plan {
    coordinates: usize,
    projection: Weights<f64>,
    offset: Vec<f64>,
    layers: Vec<(Weights<f32>, Vec<f32>)>,
    skip: Option<Weights<f32>>,
}

/// Buffers between the layers.
#[derive(Debug, Clone)]
struct Between {
    projected: Aligned<f64>,
    inputs: Aligned<f32>,
    activations: [Aligned<f32>; 2],
}

impl Forward {
    pub(super) fn new(prepared: &Prepared, instructions: Instructions) -> Forward {
        let arch = match instructions {
            Instructions::Detected => Some(Arch::new()),
            Instructions::Portable => None,
        };
        dispatch(arch, Arrange { prepared, arch })
    }

    /// Number of displacement coordinates of a frame.
    pub(super) fn coordinates(&self) -> usize {
        self.plan.coordinates
    }

    /// Forces of one frame, N, from its displacements, mm. The lengths of `displacements` and `forces_n` must fit the network.
    pub(super) fn forces(&mut self, displacements: &[f64], forces_n: &mut [f64]) {
        let Forward { arch, plan, between } = self;
        dispatch(*arch, Evaluate { plan, between, displacements, forces_n });
    }
}

#[inline(always)]
fn dispatch<Op: WithSimd>(arch: Option<Arch>, op: Op) -> Op::Output {
    match arch {
        Some(arch) => arch.dispatch(op),
        None => op.with_simd(Scalar),
    }
}

/// Stores a network in the order in which the SIMD kernels read it.
struct Arrange<'a> {
    prepared: &'a Prepared,
    arch: Option<Arch>,
}

impl WithSimd for Arrange<'_> {
    type Output = Forward;

    fn with_simd<S: Simd>(self, _: S) -> Forward {
        let Prepared { projection, offset, layers, skip } = self.prepared;
        let (inputs, coordinates) = projection.shape();
        let outputs = layers.last().map_or(0, |layer| layer.outputs);
        let widest = layers.iter().map(|layer| layer.outputs).max().unwrap_or(0);
        let arranged = |layer: &super::Dense| {
            let weights = Weights::new::<S>(layer.outputs, layer.inputs, |o, i| layer.weights[o * layer.inputs + i]);
            (weights, layer.bias.clone())
        };
        let plan = Plan {
            coordinates,
            projection: Weights::new::<S>(inputs, coordinates, |row, column| projection[(row, column)]),
            offset: offset.clone(),
            layers: layers.iter().map(arranged).collect(),
            skip: (!skip.is_empty()).then(|| Weights::new::<S>(outputs, inputs, |o, i| skip[o * inputs + i])),
        };
        let between = Between {
            projected: Aligned::zeros(padded::<f64, S>(inputs)),
            inputs: Aligned::zeros(inputs),
            activations: [(); 2].map(|()| Aligned::zeros(padded::<f32, S>(widest))),
        };
        Forward { arch: self.arch, plan, between }
    }
}

struct Evaluate<'a> {
    plan: &'a Plan,
    between: &'a mut Between,
    displacements: &'a [f64],
    forces_n: &'a mut [f64],
}

impl WithSimd for Evaluate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Plan { projection, offset, layers, skip, .. } = self.plan;
        let z = self.between.inputs.as_mut_slice();
        let projected = self.between.projected.as_mut_slice();
        projected[..offset.len()].copy_from_slice(offset);
        projection.add_product(simd, self.displacements, projected, Linear);
        for (z, projected) in z.iter_mut().zip(&*projected) {
            *z = *projected as f32;
        }
        let [from, to] = &mut self.between.activations;
        let (mut from, mut to) = (from.as_mut_slice(), to.as_mut_slice());
        for (k, (weights, bias)) in layers.iter().enumerate() {
            let y = &mut to[..padded::<f32, S>(weights.outputs())];
            y[..bias.len()].copy_from_slice(bias);
            let x = if k == 0 { &*z } else { &*from };
            if k + 1 < layers.len() {
                weights.add_product(simd, x, y, Tanh);
            } else {
                weights.add_product(simd, x, y, Linear);
                if let Some(skip) = skip {
                    skip.add_product(simd, z, y, Linear);
                }
            }
            std::mem::swap(&mut from, &mut to);
        }
        for (force_n, y) in self.forces_n.iter_mut().zip(&*from) {
            *force_n = f64::from(*y);
        }
    }
}
