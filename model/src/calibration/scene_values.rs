//! Values of calibrated moduli in a scene file.

use crate::finger::{Finger, Strip, ThicknessError};
use crate::keys::{BACK, FINGER, FRONT, RIBS, ZONE};
use toml::Value;

/// Values of a scene by key. `None` removes the key.
pub type SceneValues = Vec<(String, Option<Value>)>;

/// Values of a scene whose finger has calibrated moduli: those of `finger` times `factor`, the factors of its zones, and the relative standard deviation
/// `modulus_sd` of a factor on all moduli, all dimensionless. The standard deviation of the depth is removed, because loads determine the product of
/// moduli and depth. `thickness` states how the moduli depend on the uncertain thicknesses.
pub fn modulus_values(finger: &Finger, factor: f64, modulus_sd: f64, thickness: ThicknessError) -> SceneValues {
    let d = finger.description();
    let plates = [(FRONT.youngs_modulus_mpa.path(), d.front), (BACK.youngs_modulus_mpa.path(), d.back)];
    let ribs = d.ribs.strip.map(|strip| (RIBS.youngs_modulus_mpa.path(), strip));
    let modulus = |(key, strip): (String, Strip)| (key, factor * strip.youngs_modulus_mpa);
    let zones = d.zones.iter().enumerate().map(|(i, zone)| (ZONE.modulus_factor.path_in(i + 1), zone.modulus_factor));
    let numbers = plates.into_iter().chain(ribs).map(modulus).chain(zones);
    // Measurements that leave the modulus open, such as those of one node, leave a factor of the order of one.
    let numbers = numbers.chain([(FINGER.youngs_modulus_sigma.path(), modulus_sd.min(1.0))]);
    let mut values: SceneValues = numbers.map(|(key, number)| (key, Some(Value::from(number)))).collect();
    values.push((FINGER.depth_sigma_mm.path(), None));
    let slopes = (thickness != ThicknessError { modulus_slopes: [0.0; 3], ..thickness })
        .then(|| Value::from(thickness.modulus_slopes.to_vec()));
    values.push((FINGER.modulus_per_thickness.path(), slopes));
    // Calibrated moduli hold for the side faces with which they were computed.
    if d.side_faces.is_none() && d.poissons_ratio > 0.0 {
        values.push((FINGER.side_faces.path(), Some(Value::from("fixed"))));
    }
    values
}
