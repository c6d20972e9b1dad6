//! Network files are read back unchanged, and damaged files are refused with a message that names the fault.

use super::random_network;
use finray_model::sensing::network::{ContactSet, FORMAT, Network, NetworkError};
use finray_tests::cases;
use proptest::prelude::*;

proptest! {
    #![proptest_config(cases(24))]

    /// Files with changed bytes are refused without a panic.
    #[test]
    fn garbled_files_are_refused(changes in prop::collection::vec((any::<prop::sample::Index>(), 1..=255_u8), 1..4)) {
        let bytes = random_network(1, &[19, 20], ContactSet::Fixed, &[3], 4).to_bytes().expect("a file");
        let mut garbled = bytes.clone();
        for (position, change) in changes {
            garbled[position.index(bytes.len())] ^= change;
        }
        prop_assume!(garbled != bytes);
        prop_assert!(Network::from_bytes(&garbled).is_err());
    }
}

#[test]
fn a_file_reads_back_and_is_the_same_every_time() {
    for contact_set in [ContactSet::Fixed, ContactSet::AnyOf] {
        let network = random_network(3, &[16, 20], contact_set, &[7, 5], 9);
        let bytes = network.to_bytes().expect("a file");
        assert_eq!(Network::from_bytes(&bytes).as_ref(), Ok(&network));
        assert_eq!(network.clone().to_bytes().as_ref(), Ok(&bytes));
    }
}

#[test]
fn truncated_files_and_every_changed_byte_are_refused() {
    let bytes = random_network(1, &[19], ContactSet::Fixed, &[2], 2).to_bytes().expect("a file");
    for length in 0..bytes.len() {
        assert!(Network::from_bytes(&bytes[..length]).is_err(), "cut to {length} bytes");
    }
    for position in 0..bytes.len() {
        let mut garbled = bytes.clone();
        garbled[position] ^= 0x10;
        assert!(Network::from_bytes(&garbled).is_err(), "byte {position} changed");
    }
}

#[test]
fn messages_name_what_is_wrong() {
    let network = random_network(1, &[19, 20], ContactSet::Fixed, &[3], 4);
    let mut not_finite = network.clone();
    not_finite.layers[0].weights[5] = f32::NAN;
    let message = not_finite.to_bytes().expect_err("NaN").to_string();
    assert!(message.contains("layers.0.weight") && message.contains("index 5"), "{message}");

    let mut misfit = network.clone();
    misfit.layers[1].inputs = 4;
    let message = misfit.check().expect_err("a misfit").to_string();
    assert!(message.contains("layers.1.weight") && message.contains("[2, 3]"), "{message}");

    let mut newer = network.clone();
    newer.card.format = FORMAT + 1;
    assert_eq!(newer.check(), Err(NetworkError::Format { expected: FORMAT, found: u64::from(FORMAT) + 1 }));

    let tensors =
        [("mean", safetensors::tensor::TensorView::new(safetensors::Dtype::F32, vec![1], &[0; 4]).expect("a view"))];
    let other = safetensors::serialize(tensors, None).expect("a file");
    assert!(matches!(Network::from_bytes(&other), Err(NetworkError::Card(what)) if what.contains("finray_network")));
}
