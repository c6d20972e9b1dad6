//! A network is stored as a safetensors file, with the card as JSON in the metadata and a checksum over all contents.
//!
//! | tensor | type | shape |
//! |---|---|---|
//! | `mean` | F64 | n |
//! | `projection` | F64 | p, n |
//! | `variances`, `largest` | F64 | p |
//! | `layers.K.weight` | F32 | outputs, inputs |
//! | `layers.K.bias` | F32 | outputs |
//! | `skip` | F32 | contacts, p; missing without a skip branch |
//! | `compliance` | F64 | n, contacts; only with the contact set `AnyOf` |
//! | `sha256` | U8 | 32: of the card and of names, shapes and contents of the other tensors in order of their names |

use super::card::{FORMAT, NetworkCard};
use super::error::{require, require_shape};
use super::{Dense, Inputs, Network, NetworkError};
use nalgebra::DMatrix;
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, HashMap};

/// Key of the card in the metadata.
const CARD: &str = "finray_network";
/// Tensor that contains the checksum.
const CHECKSUM: &str = "sha256";

impl Network {
    /// Writes the network as a safetensors file. Files of equal networks have equal bytes.
    ///
    /// # Errors
    /// [`NetworkError`] if the parts of the network do not fit together.
    pub fn to_bytes(&self) -> Result<Vec<u8>, NetworkError> {
        self.check()?;
        let card = serde_json::to_string(&self.card).map_err(|error| card_error(&error))?;
        let n = self.inputs.coordinate_count();
        let (p, m) = (self.inputs.count(), self.contact_count());
        let mut tensors = BTreeMap::new();
        let mut add = |name: String, shape: &[usize], numbers: Stored| {
            tensors.insert(name, (numbers.0, shape.to_vec(), numbers.1));
        };
        add("mean".into(), &[n], f64s(self.inputs.mean.iter()));
        add("projection".into(), &[p, n], f64s(self.inputs.projection.transpose().iter()));
        add("variances".into(), &[p], f64s(self.inputs.variances.iter()));
        add("largest".into(), &[p], f64s(self.inputs.largest.iter()));
        for (k, layer) in self.layers.iter().enumerate() {
            add(Dense::weights_name(k), &[layer.outputs, layer.inputs], f32s(&layer.weights));
            add(Dense::bias_name(k), &[layer.outputs], f32s(&layer.bias));
        }
        if !self.skip.is_empty() {
            add("skip".into(), &[m, p], f32s(&self.skip));
        }
        if let Some(compliance) = &self.compliance {
            add("compliance".into(), &[n, m], f64s(compliance.transpose().iter()));
        }
        let mut views = BTreeMap::new();
        for (name, (dtype, shape, bytes)) in &tensors {
            views.insert(name.as_str(), TensorView::new(*dtype, shape.clone(), bytes).map_err(|e| unreadable(&e))?);
        }
        let sum = checksum(&card, &views);
        views.insert(CHECKSUM, TensorView::new(Dtype::U8, vec![sum.len()], &sum).map_err(|e| unreadable(&e))?);
        // The metadata have only one key, because the order of several keys in a hash map is not fixed.
        let metadata = HashMap::from([(CARD.to_owned(), card)]);
        safetensors::serialize(views, Some(metadata)).map_err(|error| unreadable(&error))
    }

    /// Reads a network from the bytes of its file.
    ///
    /// # Errors
    /// [`NetworkError`] naming the missing, wrong or damaged tensor or key, with the expected content.
    pub fn from_bytes(bytes: &[u8]) -> Result<Network, NetworkError> {
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(|error| unreadable(&error))?;
        let file = SafeTensors::deserialize(bytes).map_err(|error| unreadable(&error))?;
        let text = header.metadata().as_ref().and_then(|metadata| metadata.get(CARD));
        let text = text.ok_or_else(|| NetworkError::Card(format!("expected the metadata key {CARD}, found none")))?;
        let card = read_card(text)?;
        let mut tensors: BTreeMap<&str, TensorView> = file.iter().collect();

        let stored_sum = take(&mut tensors, CHECKSUM, Dtype::U8)?.data().to_vec();
        let sum = checksum(text, &tensors);
        let mut take_vector = |name: &str| {
            let tensor = take(&mut tensors, name, Dtype::F64)?;
            require_shape(name, &[tensor.data().len() / size_of::<f64>()], tensor.shape())?;
            Ok::<_, NetworkError>(to_f64s(&tensor))
        };
        let mean = take_vector("mean")?;
        let variances = take_vector("variances")?;
        let largest = take_vector("largest")?;
        let projection = to_matrix("projection", &take(&mut tensors, "projection", Dtype::F64)?)?;
        let inputs = Inputs { mean, projection, variances, largest };
        let mut layers = Vec::new();
        while layers.is_empty() || tensors.contains_key(Dense::weights_name(layers.len()).as_str()) {
            let weights = take(&mut tensors, &Dense::weights_name(layers.len()), Dtype::F32)?;
            let bias = take(&mut tensors, &Dense::bias_name(layers.len()), Dtype::F32)?;
            let [outputs, inputs] = matrix_shape(&Dense::weights_name(layers.len()), &weights)?;
            layers.push(Dense { inputs, outputs, weights: to_f32s(&weights), bias: to_f32s(&bias) });
        }
        let skip = match tensors.contains_key("skip") {
            true => to_f32s(&take(&mut tensors, "skip", Dtype::F32)?),
            false => Vec::new(),
        };
        let compliance = match tensors.contains_key("compliance") {
            true => Some(to_matrix("compliance", &take(&mut tensors, "compliance", Dtype::F64)?)?),
            false => None,
        };
        let names = tensors.keys().copied().collect::<Vec<_>>().join(", ");
        require(names.is_empty(), "the file", "no other tensors", names)?;
        let network = Network::new(card, inputs, layers, skip, compliance)?;
        // The checksum is compared last, so that errors name the wrong part where possible.
        if stored_sum == sum { Ok(network) } else { Err(NetworkError::Damaged) }
    }
}

/// Reads the card. The version is checked first, because cards of other versions have other keys.
fn read_card(text: &str) -> Result<NetworkCard, NetworkError> {
    let value: serde_json::Value = serde_json::from_str(text).map_err(|error| card_error(&error))?;
    let Some(found) = value.get("format").and_then(serde_json::Value::as_u64) else {
        return Err(NetworkError::Card("expected a JSON object with the number `format`".to_owned()));
    };
    if found != u64::from(FORMAT) {
        return Err(NetworkError::Format { expected: FORMAT, found });
    }
    serde_json::from_str(text).map_err(|error| card_error(&error))
}

fn card_error(error: &serde_json::Error) -> NetworkError {
    NetworkError::Card(error.to_string())
}

fn unreadable(error: &safetensors::SafeTensorError) -> NetworkError {
    NetworkError::NotSafetensors(error.to_string())
}

/// Type and bytes of a tensor.
type Stored = (Dtype, Vec<u8>);

fn f64s<'a>(numbers: impl Iterator<Item = &'a f64>) -> Stored {
    (Dtype::F64, numbers.flat_map(|number| number.to_le_bytes()).collect())
}

fn f32s(numbers: &[f32]) -> Stored {
    (Dtype::F32, numbers.iter().flat_map(|number| number.to_le_bytes()).collect())
}

fn to_f64s(tensor: &TensorView) -> Vec<f64> {
    tensor.data().as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect()
}

fn to_f32s(tensor: &TensorView) -> Vec<f32> {
    tensor.data().as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect()
}

fn to_matrix(name: &str, tensor: &TensorView) -> Result<DMatrix<f64>, NetworkError> {
    let [rows, columns] = matrix_shape(name, tensor)?;
    Ok(DMatrix::from_row_slice(rows, columns, &to_f64s(tensor)))
}

fn matrix_shape(name: &str, tensor: &TensorView) -> Result<[usize; 2], NetworkError> {
    let shape = tensor.shape();
    require(shape.len() == 2, name, "a matrix", format!("the shape {shape:?}"))?;
    Ok([shape[0], shape[1]])
}

/// Removes a tensor from the tensors of a file, checks the type of the tensor, and returns the tensor.
fn take<'d>(
    tensors: &mut BTreeMap<&str, TensorView<'d>>,
    name: &str,
    dtype: Dtype,
) -> Result<TensorView<'d>, NetworkError> {
    let found = tensors.get(name).map_or("none".to_owned(), |tensor| tensor.dtype().to_string());
    let tensor = tensors.remove(name).filter(|tensor| tensor.dtype() == dtype);
    tensor.ok_or_else(|| {
        let expected = format!("a tensor of type {dtype}");
        NetworkError::Part { part: name.to_owned(), expected, found }
    })
}

fn checksum(card: &str, tensors: &BTreeMap<&str, TensorView>) -> [u8; 32] {
    let mut hash = Sha256::new();
    hash.update(card.as_bytes());
    for (name, tensor) in tensors {
        hash.update(format!("\n{name} {:?}\n", tensor.shape()).as_bytes());
        hash.update(tensor.data());
    }
    hash.finalize().into()
}
