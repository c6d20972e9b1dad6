//! The unloaded finger in a stream: recognised by its scatter at rest, and its drift shown.

use finray_model::measurement::BaseUncertainty;
use finray_model::mesh::Load;
use finray_model::observation::{Observation, ObservedBase, ObservedMarker};
use finray_model::sensing::{ContactPosition, ContactQuestion, Direction};
use finray_model::sensor::{FingerTracker, FrameState, SensorContacts, SensorOptions, ZeroDrift};
use finray_model::{Finger, Kinematics, Mesh, NodeId, Scene, Vector, statics};
use finray_tests::random_stream;
use nalgebra::Isometry2;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Standard deviation of the noise in a coordinate, mm.
const NOISE_MM: f64 = 0.02;
const REST_FRAMES: usize = 10;

fn normal(chance: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(chance)
}

fn vector(chance: &mut ChaCha8Rng) -> Vector {
    Vector::new(normal(chance), normal(chance))
}

fn nodes(finger: &Finger) -> impl Iterator<Item = NodeId> {
    (1..=finger.key_node_count()).map(NodeId)
}

/// A finger and its markers, which a camera sees with noise.
struct Watched {
    scene: Scene,
    chance: ChaCha8Rng,
}

impl Watched {
    fn new(case: u64) -> Watched {
        let scene = Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("a scene");
        Watched { scene, chance: random_stream(471, case) }
    }

    /// Displacement of each node under a normal force.
    fn moved(&self, s_mm: f64, force_n: f64) -> Vec<Vector> {
        self.under(&[(s_mm, force_n)])
    }

    /// Displacement of each node under normal forces, given as positions (mm) and forces (N).
    fn under(&self, forces: &[(f64, f64)]) -> Vec<Vector> {
        let finger = &self.scene.finger;
        let mesh = Mesh::with_elements_per_member(finger, 8);
        let load = |(s_mm, force_n): &(f64, f64)| Load::at_position(*s_mm, finger.direction(0.0) * *force_n);
        let loads: Vec<Load> = forces.iter().map(load).collect();
        let shape = statics::solve(&mesh, &loads, Kinematics::Corotational).expect("carried");
        nodes(finger).map(|node| shape.motion(node).displacement).collect()
    }

    /// A frame of all markers, clamped ones included.
    fn frame(&mut self, moved: impl Fn(NodeId) -> Vector) -> Observation {
        let finger = &self.scene.finger;
        let marker = |node: NodeId| {
            let position = finger.position(node) + moved(node) + NOISE_MM * vector(&mut self.chance);
            ObservedMarker {
                position: Some(position),
                displacement: None,
                ..ObservedMarker::displaced(node, Vector::zeros())
            }
        };
        Observation { markers: nodes(finger).map(marker).collect(), ..Observation::default() }
    }

    fn at_rest(&mut self) -> Observation {
        self.frame(|_| Vector::zeros())
    }
}

fn asked() -> SensorContacts {
    SensorContacts::Asked(vec![ContactQuestion::new(None, Direction::Angle(0.0))])
}

fn options(noise_mm: Option<f64>) -> SensorOptions {
    SensorOptions { noise_mm, ..SensorOptions::default() }
}

/// States and last drift of the frames after the rest frames.
fn watched(
    of: &mut Watched,
    noise_mm: Option<f64>,
    rest_frames: usize,
    frames: impl IntoIterator<Item = Vec<Vector>>,
) -> (Vec<FrameState>, Vec<ZeroDrift>) {
    let scene = of.scene.clone();
    let mut finger =
        FingerTracker::new("", scene.clone(), asked(), options(noise_mm), rest_frames).expect("a question");
    for _ in 0..rest_frames {
        assert_eq!(finger.evaluate(Ok(of.at_rest())).drift, None);
    }
    let (mut states, mut drifts) = (Vec::new(), Vec::new());
    for moved in frames {
        let seen = of.frame(|node| moved.get(node.0 - 1).copied().unwrap_or_default());
        let result = finger.evaluate(Ok(seen));
        states.push(result.state);
        drifts.extend(result.drift);
        let is_said = result.warning().is_some_and(|warning| warning.contains("zero drift"));
        assert_eq!(is_said, result.drift.is_some_and(|drift| drift.is_significant()));
    }
    (states, drifts)
}

/// Without drift, the mean square of the drift is the variance of the two means, and no drift is significant. The variance of a moving average with
/// the weight w of the newest frame is w / (2 - w) times that of a frame.
#[test]
fn noise_is_no_drift() {
    let mut squares = Vec::new();
    for case in 0..40 {
        for noise_mm in [Some(NOISE_MM), None] {
            let mut of = Watched::new(case);
            let (_, drifts) = watched(&mut of, noise_mm, REST_FRAMES, vec![Vec::new(); 60]);
            assert!(drifts.len() >= 59 && drifts.iter().all(|drift| !drift.is_significant()), "{case}");
            squares.extend(drifts.last().map(|drift| drift.rms_mm.powi(2)));
        }
    }
    let weight = 1.0 / REST_FRAMES as f64;
    let expected = 2.0 * NOISE_MM.powi(2) * (weight + weight / (2.0 - weight));
    let found = squares.iter().sum::<f64>() / squares.len() as f64;
    // 40 independent means of 25 markers in two coordinates: a relative standard deviation of sqrt(2 / 2000) = 3.2 %.
    assert!((found / expected - 1.0).abs() < 4.0 * 0.032, "{found} for {expected}");
}

/// Drifts of about 0.6 standard deviations of a frame are too small to change the state of single frames. The means show them and their kind: the camera
/// has moved, or the finger has bent. A bend resembles a rigid motion, so its kind needs means over many frames.
#[test]
fn a_small_drift_is_shown_with_its_kind() {
    let bent = Watched::new(0).moved(110.0, 1.0);
    let largest_mm = bent.iter().map(|moved| moved.norm()).fold(0.0, f64::max);
    let rms_mm = |drift: &[Vector]| (drift.iter().map(Vector::norm_squared).sum::<f64>() / drift.len() as f64).sqrt();
    let kinds = [
        (vec![Vector::new(0.6 * NOISE_MM, -0.6 * NOISE_MM); bent.len()], REST_FRAMES, true),
        (bent.iter().map(|moved| moved * 1.2 * NOISE_MM / largest_mm).collect(), 100, false),
    ];
    for (case, (drift, rest_frames, is_rigid)) in kinds.into_iter().enumerate() {
        for noise_mm in [Some(NOISE_MM), None] {
            let mut of = Watched::new(100 + case as u64);
            let (states, drifts) = watched(&mut of, noise_mm, rest_frames, vec![drift.clone(); 200]);
            let free = states.iter().filter(|state| **state == FrameState::None).count();
            assert!(free >= 190, "{case}: {free} of 200 free");
            let last = drifts.last().expect("a drift");
            assert!(last.is_significant() && last.is_rigid == is_rigid, "{case}: {last:?}");
            assert!((last.rms_mm / rms_mm(&drift) - 1.0).abs() < 0.4, "{case}: {last:?} for {}", rms_mm(&drift));
        }
    }
}

/// Without a stated noise, the rest frames state it: the unloaded finger is recognised, although its clamped markers show noise, too, and a second contact
/// is found. One change between rest frames does not suffice.
#[test]
fn rest_frames_state_the_noise() {
    let mut of = Watched::new(200);
    let (states, _) = watched(&mut of, None, REST_FRAMES, vec![Vec::new(); 500]);
    let wrong = states.iter().filter(|state| **state != FrameState::None).count();
    assert!(wrong <= 2, "{wrong} of 500");
    let (one, two) = (of.moved(80.0, 0.3), of.moved(80.0, 0.5));
    let (states, _) = watched(&mut of, None, REST_FRAMES, [one, two]);
    assert_eq!(states, [FrameState::Contact; 2]);
    let (states, _) = watched(&mut of, None, 2, vec![Vec::new(); 20]);
    assert!(states.iter().all(|state| *state != FrameState::None), "{states:?}");
    let scene = of.scene.clone();
    let mut finger = FingerTracker::new("", scene.clone(), asked(), options(None), REST_FRAMES).expect("a question");
    for _ in 0..REST_FRAMES {
        finger.evaluate(Ok(of.at_rest()));
    }
    let both = of.under(&[(60.0, 1.0), (120.0, 0.5)]);
    let seen = of.frame(|node| both[node.0 - 1]);
    assert_eq!(finger.evaluate(Ok(seen)).forces().len(), 2);
}

/// Rest frames whose markers do not have the shape of the scene's finger are refused: another unit, another scale, mirrored, or nodes in reverse order.
/// Shifted and rotated markers are accepted, and their forces are those of the finger frame.
#[test]
fn rest_frames_must_show_the_finger_of_the_scene() {
    let mut of = Watched::new(400);
    let scene = of.scene.clone();
    let changed = |seen: Observation, change: &dyn Fn(ObservedMarker) -> ObservedMarker| Observation {
        markers: seen.markers.into_iter().map(change).collect(),
        ..Observation::default()
    };
    let moved_to = |to: fn(Vector) -> Vector| {
        move |marker: ObservedMarker| ObservedMarker { position: marker.position.map(to), ..marker }
    };
    let reversed = |marker: ObservedMarker| ObservedMarker { node: NodeId(26 - marker.node.0), ..marker };
    let invalid: [&dyn Fn(ObservedMarker) -> ObservedMarker; 6] = [
        &moved_to(|at| at / 10.0),
        &moved_to(|at| 1.1 * at),
        &moved_to(|at| Vector::new(at.y, at.x)),
        &reversed,
        &|marker| ObservedMarker { node: NodeId(marker.node.0 + 1), ..marker },
        &|marker| ObservedMarker { sd_mm: Some(-1.0), ..marker },
    ];
    for (case, change) in invalid.into_iter().enumerate() {
        let mut finger = FingerTracker::new("", scene.clone(), asked(), options(None), 1).expect("a question");
        let result = finger.evaluate(Ok(changed(of.at_rest(), change)));
        assert_eq!(result.state, FrameState::Refused, "{case}");
        // An observation that is invalid after the rest frames is refused, too.
        if case > 3 {
            finger.evaluate(Ok(of.at_rest()));
            assert_eq!(finger.evaluate(Ok(changed(of.at_rest(), change))).state, FrameState::Refused, "{case}");
        }
    }
    let turned = moved_to(|at| nalgebra::Rotation2::new(0.05) * at + Vector::new(3.0, -2.0));
    let pressed = of.moved(80.0, 2.0);
    let mut finger = FingerTracker::new("", scene.clone(), asked(), options(Some(NOISE_MM)), 20).expect("a question");
    for _ in 0..20 {
        finger.evaluate(Ok(changed(of.at_rest(), &turned)));
    }
    let mut held = 0;
    for _ in 0..100 {
        let seen = of.frame(|node| pressed[node.0 - 1]);
        let result = finger.evaluate(Ok(changed(seen, &turned)));
        let [low, high] = result.sensed.unwrap_or_else(|| panic!("{:?}", result.refused)).forces[0].interval_n();
        held += usize::from((low..=high).contains(&2.0));
    }
    // The binomial distribution of 100 intervals of 95 % reaches 88 in 99.6 % of the cases.
    assert!(held >= 88, "{held} of 100");
}

/// If a force acts in the last rest frames, every later line warns, with and without a stated noise.
#[test]
fn a_finger_that_moves_in_the_rest_frames_causes_a_warning() {
    for noise_mm in [Some(NOISE_MM), None] {
        for loaded_from in [REST_FRAMES, 7, REST_FRAMES - 1] {
            let mut of = Watched::new(500);
            let scene = of.scene.clone();
            let pressed = of.moved(80.0, 0.5);
            let mut finger =
                FingerTracker::new("", scene.clone(), asked(), options(noise_mm), REST_FRAMES).expect("valid");
            for frame in 0..REST_FRAMES {
                let seen = of.frame(|node| if frame >= loaded_from { pressed[node.0 - 1] } else { Vector::zeros() });
                finger.evaluate(Ok(seen));
            }
            let seen = of.frame(|node| pressed[node.0 - 1]);
            let warning = finger.evaluate(Ok(seen)).warning().unwrap_or_default();
            let is_said = warning.contains("moved during the rest frames");
            assert_eq!(is_said, loaded_from < REST_FRAMES, "{noise_mm:?}, {loaded_from}: {warning}");
        }
    }
}

/// Contacts that no observation can have are refused before the first observation.
#[test]
fn impossible_contacts_are_refused_at_once() {
    let scene = Scene::from_toml(finray_fixtures::PAPER_SCENE).expect("a scene");
    let at = |position| ContactQuestion::new(Some(position), Direction::Angle(0.0));
    let [clamped, missing] = [1, 99].map(|node| vec![at(ContactPosition::Node(NodeId(node)))]);
    let off = |s_mm| vec![at(ContactPosition::at(s_mm))];
    let same = vec![at(ContactPosition::at(80.0)); 2];
    for questions in [vec![], clamped, missing, off(-5.0), off(800.0), same] {
        let refused = FingerTracker::new("", scene.clone(), SensorContacts::Asked(questions.clone()), options(None), 0);
        assert!(refused.is_err(), "{questions:?}");
    }
    let question = SensorContacts::Asked(off(80.0));
    let no_mesh = SensorOptions { mesh_nodes: Some(0), ..options(None) };
    assert!(FingerTracker::new("", scene.clone(), question, no_mesh, 0).is_err());
}

/// The pose of the base has an independent error in each image. One rest frame doubles the variance of this error in a displacement, and thus the
/// variance of a force, to which this error contributes most.
#[test]
fn the_base_at_rest_is_uncertain() {
    let base = BaseUncertainty { sd_mm: 0.2, sd_rad: 1e-3, ..BaseUncertainty::default() };
    let mut of = Watched::new(300);
    let scene = of.scene.clone();
    let at = ContactPosition::at(80.0);
    let asked = SensorContacts::Asked(vec![ContactQuestion::new(Some(at), Direction::Angle(0.0))]);
    let pressed = of.moved(80.0, 2.0);
    let streams = 400;
    let mut squares = 0.0;
    for _ in 0..streams {
        let mut finger = FingerTracker::new("", scene.clone(), asked.clone(), options(None), 1).expect("a question");
        for frame in [false, true] {
            let (shift, turn) = (base.sd_mm * vector(&mut of.chance), base.sd_rad * normal(&mut of.chance));
            let mut seen = of.frame(|node| {
                let moved = if frame { pressed[node.0 - 1] } else { Vector::zeros() };
                let at = scene.finger.position(node) + moved;
                moved + shift + turn * Vector::new(-at.y, at.x)
            });
            for marker in &mut seen.markers {
                let turned_mm = base.sd_rad * marker.position.unwrap_or_default().norm();
                marker.own_sd_mm = Some(NOISE_MM);
                marker.sd_mm = Some(NOISE_MM.hypot(base.sd_mm).hypot(turned_mm));
            }
            seen.base = Some(ObservedBase { pose: Isometry2::identity(), uncertainty: Some(base), is_known: true });
            let result = finger.evaluate(Ok(seen));
            if frame {
                let sensed = result.sensed.unwrap_or_else(|| panic!("{:?}: {:?}", result.state, result.refused));
                squares += ((sensed.forces[0].force_n - 2.0) / sensed.forces[0].sigma_n).powi(2);
            }
        }
    }
    let mean = squares / f64::from(streams);
    assert!((mean - 1.0).abs() < 4.0 * (2.0 / f64::from(streams)).sqrt(), "{mean}");
}
