//! Common properties of the markers in an image: outline, blur, noise, and displacement of colour relative to brightness (by compression and lens).

use super::disc::{Buffers, ColourShift, Disc, LARGEST_BLUR, Outline, UsualCover, View, median};
use super::motion::{LARGEST_MOTION, motion_blur_px};
use super::{LocateError, Located};
use finray_model::observation::EstimatedNoise;
use finray_model::scene::Markers;
use finray_model::{NodeId, Vector};
use nalgebra::{Matrix2, Vector2};

/// Variance due to rounding to grey levels, in squared grey levels.
const ROUNDING: f64 = 0.1;
/// Brightness and colour get different weights if the ratio of their variances exceeds this.
const UNEVEN: f64 = 3.0;

/// A marker is omitted if its standard deviation exceeds the median of all markers by this factor. A mean with such a marker has at most 1 % more
/// information, so that little depends on the side of the limit on which a marker lies.
const FAINT: f64 = 10.0;
/// Contribution of a marker to a mean is limited to this number of medians. Squared residuals of whole markers are at least as scattered as an
/// exponential distribution, of which 0.1 % is larger; in compressed images, a limit of 5 medians makes standard deviations 5 % too small.
const LARGEST_SHARE: f64 = 10.0;
/// Prior standard deviation of the displacement of colour relative to brightness, px. Encoders place the samples of colour, which two by two pixels share,
/// at the middle or at the edge of these pixels: half a pixel apart. Files often state the wrong place, or none.
const COLOUR_SHIFT_SD_PX: f64 = 0.5;
/// A step of the displacement of colour counts as none below this, px.
const COLOUR_STILL_PX: f64 = 0.01;
/// Largest number of rounds. Each round measures the centres and the displacement of colour; each round except the last corrects the displacement.
/// Several corrections of the displacement may be needed, because each correction is of first order.
const COLOUR_ROUNDS: usize = 4;
/// Degrees of freedom of the variance that correlated errors of pixels add: it is extrapolated, and differs with the encoder and the motion. In h264
/// frames (crf 18 to 30) of eight fingers that another program drew, the mean square of error over standard deviation exceeds the limit of the F
/// distribution with 8 degrees of freedom for p = 1e-4 in none of 768 frames, and that of chi-squared in a quarter. The number was chosen with these
/// frames.
const EXCESS_DEGREES_OF_FREEDOM: f64 = 8.0;
/// Errors of the edge model add up to this multiple of the variance of independent pixel errors in clean images, where they are known. Only an excess
/// beyond it is of compression.
const CLEAN_EXCESS: f64 = 3.0;
/// Variance of an error that all markers of an image share, as a multiple of the variance of the mean of independent markers, for the variance that
/// correlated errors of pixels add: 0.3 (JPEG, quality 75), 1 (h264, crf 23) and 2.5 (crf 30) in the images of [`EXCESS_DEGREES_OF_FREEDOM`]. It is
/// multiplied by the square of that share of the variance, so that it hardly widens clean images.
const SHARED_VARIANCE: f64 = 1.5;
/// Standard deviation of a coordinate due to motion blur, as a share of that blur. The error arises because the edge model assumes isotropic blur.
const MOTION_SD: f64 = 0.1;

/// Common properties of the discs in an image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Common {
    /// Common radius and blurs of the discs.
    pub outline: Outline,
    /// Weights of brightness and colour, dimensionless; see [`View`].
    pub weights: [f64; 2],
    /// Displacement of colour relative to brightness, px; see [`View`].
    pub colour_shift_px: Vector,
    /// Standard deviation of the motion blur, px, see [`motion_blur_px`]; `None` without motion blur.
    pub motion_px: Option<f64>,
    /// Standard deviation that motion blur adds to each coordinate, mm.
    pub motion_sd_mm: f64,
}

/// Measures the centres of the discs again, with one common outline (radius and blurs) for all discs. All markers have the same size and sharpness,
/// so every marker gets the median radius and blurs of all markers. If colour is noisier than brightness, as after compression, colour gets less
/// weight. A disc that no longer fits with the common outline is removed. `view` must give equal weights to brightness and colour. `radius_px` is the
/// radius of a marker at the middle of the finger, px.
///
/// # Errors
/// [`LocateError::Blurred`] or [`LocateError::Moved`] if the blur is too large for the markers' radius.
pub(super) fn measure_together(
    mut view: View,
    markers: &Markers,
    radius_px: f64,
    named: &mut Vec<(NodeId, Disc)>,
    buffers: &mut Buffers,
) -> Result<Common, LocateError> {
    let noise =
        [0, 1].map(|part| median(named.iter().map(|(_, disc)| disc.noise[part])).unwrap_or_default() + ROUNDING);
    let least = noise[0].min(noise[1]);
    let is_even = noise[0].max(noise[1]) < UNEVEN * least;
    if !is_even {
        view.weights = noise.map(|noise| least / noise);
    }
    let mut rounds = 0;
    loop {
        if !is_even || rounds > 0 {
            for (_, disc) in named.iter_mut() {
                *disc = view.measure(markers.radius_mm, &disc.pixel, buffers).unwrap_or(*disc);
            }
        }
        let outline = outline_of(named.iter().map(|(_, disc)| *disc));
        let (blur_px, radius_px) = (outline.blurs_px[0], radius_px * outline.radius_mm / markers.radius_mm);
        if blur_px > LARGEST_BLUR * radius_px {
            return Err(LocateError::Blurred { blur_px, radius_px });
        }
        let ColourShift { normal, gradient } = measure_centres(&view, outline, named, buffers);
        // Correlated errors of neighbouring pixels make a measured displacement of colour less certain, and the prior more important.
        let excess = wider(named.iter().map(|(_, disc)| disc.excess_variances)).powi(2);
        let prior = excess / COLOUR_SHIFT_SD_PX.powi(2);
        let posterior = (normal + Matrix2::identity() * prior).try_inverse().unwrap_or_default();
        let shift: Vector = posterior * (gradient - view.colour_shift_px * prior);
        rounds += 1;
        if rounds == COLOUR_ROUNDS || shift.norm() < COLOUR_STILL_PX {
            let (weights, colour_shift_px) = (view.weights, view.colour_shift_px);
            let motion_px = motion_blur_px(view.image, named.iter().map(|(_, disc)| disc), radius_px, blur_px);
            if let Some(blur_px) = motion_px.filter(|motion_px| *motion_px > LARGEST_MOTION * radius_px) {
                return Err(LocateError::Moved { blur_px, radius_px });
            }
            let motion_sd_mm = MOTION_SD * motion_px.unwrap_or(0.0) * outline.radius_mm / radius_px;
            return Ok(Common { outline, weights, colour_shift_px, motion_px, motion_sd_mm });
        }
        view.colour_shift_px += shift;
    }
}

/// Median radius and blurs of discs.
pub(super) fn outline_of(discs: impl Iterator<Item = Disc> + Clone) -> Outline {
    let median_of = |of: &dyn Fn(Disc) -> f64| median(discs.clone().map(of)).unwrap_or_default();
    Outline {
        radius_mm: median_of(&|disc| disc.outline.radius_mm),
        blurs_px: [0, 1].map(|part| median_of(&|disc| disc.outline.blurs_px[part])),
    }
}

/// Measures the centres of discs with a common outline, and removes discs that do not fit. Returns the sum of the discs' normal equations for a further
/// displacement of colour.
fn measure_centres(
    view: &View,
    outline: Outline,
    named: &mut Vec<(NodeId, Disc)>,
    buffers: &mut Buffers,
) -> ColourShift {
    let mut all = ColourShift { normal: Matrix2::zeros(), gradient: Vector2::zeros() };
    named.retain_mut(|(_, disc)| match view.measure_centre_and_colour(outline, &disc.pixel, buffers) {
        Some((found, shift)) => {
            *disc = found;
            all.normal += shift.normal;
            all.gradient += shift.gradient;
            true
        }
        None => false,
    });
    all
}

/// Located markers from their discs, without uncertain ones. The markers of each plate share a colour, so one factor multiplies the standard deviations
/// of all of them. Also returns the noise if pixel errors are correlated.
///
/// # Reference
/// Satterthwaite, Biometrics Bulletin 2, 1946: degrees of freedom of a sum of a known and an estimated variance.
pub(super) fn located(
    named: &[(NodeId, Disc)],
    on_front: &[NodeId],
    common: &Common,
) -> (Vec<Located>, Option<EstimatedNoise>) {
    let [front, back] = [true, false].map(|is_front| {
        let of_plate = named.iter().filter(|(node, _)| on_front.contains(node) == is_front);
        wider(of_plate.map(|(_, disc)| disc.excess_variances))
    });
    let usual = UsualCover::of(named.iter().map(|(_, disc)| disc.cover));
    let located = |&(node, disc): &(NodeId, Disc)| {
        let wider = if on_front.contains(&node) { front } else { back };
        let sd_mm = (disc.sd_mm * wider).hypot(common.motion_sd_mm);
        Located { node, pixel: disc.pixel, position: disc.centre, sd_mm: usual.widened_mm(sd_mm, &disc.cover) }
    };
    let located = without_faint(named.iter().map(located).collect());
    let count = located.len() as f64;
    let mean = |of: &dyn Fn(&Located) -> f64| located.iter().map(of).sum::<f64>() / count;
    let excess = mean(&|of| if on_front.contains(&of.node) { front } else { back }.powi(2));
    let estimated = (1.0 - CLEAN_EXCESS / excess).max(0.0).powi(2);
    let noise = (estimated > 0.0).then(|| EstimatedNoise {
        degrees_of_freedom: EXCESS_DEGREES_OF_FREEDOM / estimated,
        shared_sd_mm: (SHARED_VARIANCE * estimated * mean(&|of| of.sd_mm.powi(2)) / count).sqrt(),
    });
    (located, noise)
}

/// The markers without those that are far less certain than the others.
pub(super) fn without_faint(mut located: Vec<Located>) -> Vec<Located> {
    let most_mm = FAINT * median(located.iter().map(|marker| marker.sd_mm)).unwrap_or_default();
    located.retain(|marker| marker.sd_mm <= most_mm);
    located
}

/// Factor by which standard deviations exceed the values for independent pixel errors. The residuals of one marker determine the factor poorly; the
/// residuals of all markers of a colour together determine it well.
///
/// The fitted centre absorbs the residuals with one period around the edge. Residuals with longer periods have more power. The power of the residuals
/// with one period is extrapolated from the powers with two and three periods, along a Gaussian S(n) = a exp(-c n^2) of the number of periods n. The
/// factor is 1 without markers.
pub(super) fn wider(excess_variances: impl Iterator<Item = [f64; 2]> + Clone) -> f64 {
    let [two, three] = [0, 1].map(|periods| bounded_mean(excess_variances.clone().map(|of| of[periods])));
    let of_one_period = two * (two / three).max(1.0).powf(3.0 / 5.0);
    of_one_period.max(1.0).sqrt()
}

/// Mean of numbers that are at most [`LARGEST_SHARE`] medians, so that one marker that something covers does not widen all others; NaN without numbers.
fn bounded_mean(numbers: impl Iterator<Item = f64> + Clone) -> f64 {
    let most = LARGEST_SHARE * median(numbers.clone()).unwrap_or_default();
    numbers.clone().map(|number| number.min(most)).sum::<f64>() / numbers.count() as f64
}

#[cfg(test)]
#[path = "../../tests/units/together.rs"]
mod tests;
