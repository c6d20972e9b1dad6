//! The entries: every key of every table of a scene.
// Sentences name tables of the scene in brackets, which are no links.
#![allow(rustdoc::broken_intra_doc_links)]

use super::Need::{Of, Optional, Or, Required, RequiredIf};
use super::Range::{Above, AtMost, Between, ByOthers, Finite, Positive, Whole, Within};
use super::{
    BracketLengths, Count, Entry, Key, KeyList, Number, Numbers, Occurs, Pairs, Quantity, Range, RibLengths,
    RibNumbers, Rows, SceneTable, SideLengths, Table, Text, Word,
};

/// Radius of the rods, mm: the paper's have a diameter of 3 mm (Xu et al. 2021, sec. II).
pub const ROD_RADIUS_MM: f64 = 1.5;

const NOT_NEGATIVE: Range = Range::NOT_NEGATIVE;
const POSITIVE: Range = Range::POSITIVE;
/// Largest length of a linkage, object or path in mm, and largest force, rate and gravity in their units.
const LARGEST: f64 = 1e4;
/// Farthest distance of the finger from the camera, mm.
const FARTHEST_MM: f64 = 1e5;
/// Largest size of a marker, mm.
const LARGEST_MARKER_MM: f64 = 1e3;
/// Longest focal length, px.
const LONGEST_FOCUS_PX: f64 = 1e7;
/// Largest coefficient of friction: rubber on rubber reaches 2.
const LARGEST_FRICTION: f64 = 10.0;
/// A base that turns by more degrees under a newton is no base.
const LARGEST_TURN: f64 = 10.0;
/// A joint that may be elsewhere by more is no joint of the finger, mm.
const LARGEST_JOINT_SIGMA_MM: f64 = 10.0;
/// Most steps that are of use.
const MOST_STEPS: usize = 10_000;

const BELOW_RADIUS: Range = ByOthers("zero or more and below radius_mm");
const LENGTH: Quantity = Quantity("length", "mm");
const POSITION: Quantity = Quantity("position", "mm");
const MODULUS: Quantity = Quantity("modulus", "MPa");
const ANGLE: Quantity = Quantity("angle", "degrees");
const TURN: Quantity = Quantity("angle", "degrees a newton");
const FORCE: Quantity = Quantity("force", "N");
const STRAIN: Quantity = Quantity("strain", "");
const FRICTION: Quantity = Quantity("coefficient of friction", "");
const SIGMA: &str = "standard deviation";
const TRUE_FALSE: [&str; 2] = ["true", "false"];
const COLOUR: Quantity = Quantity("red, green and blue", "");

/// Tables of one kind: their statics with their paths, and their keys.
macro_rules! tables {
    ($($name:ident = $path:literal),+: $keys:ident, $occurs:ident, $about:literal;
     $($key:ident: $kind:ident $(<$n:literal>)? ($($value:tt)*), $need:expr, $says:literal;)*) => {
        #[doc = $about]
        #[derive(Debug)]
        pub struct $keys {
            $(#[doc = $says] pub $key: Key<$kind $(<$n>)?>,)*
        }

        impl $keys {
            const fn of(table: &'static str) -> $keys {
                $keys {
                    $($key: Key {
                        table,
                        name: stringify!($key),
                        kind: $kind $(::<$n>)? ($($value)*),
                        need: $need,
                        says: $says,
                    },)*
                }
            }
        }

        impl KeyList for $keys {
            fn entries(&self) -> Vec<Entry> {
                vec![$(self.$key.entry()),*]
            }
        }

        $(#[doc = $about]
        pub static $name: Table<$keys> =
            Table { path: $path, occurs: Occurs::$occurs, says: $about, keys: $keys::of($path) };)+
    };
}

/// All tables, in the order of the reference.
pub static TABLES: [&dyn SceneTable; 16] = [
    &TOP, &FINGER, &FRONT, &BACK, &RIBS, &ZONE, &ASSEMBLY, &CAMERA, &MARKERS, &BASE, &REFERENCE, &CONTACT, &TOUCHED,
    &OBJECT, &GRIPPER, &GRASP,
];

tables! {
    TOP = "": TopKeys, Once, "Keys above all tables.";
    name: Text(), Required, "Name of the scene.";
}

tables! {
    FINGER = "finger": FingerKeys, Once,
        "The finger: two plates in a V and ribs across. The frame of the finger has its origin in the middle of the base line, x towards the tip \
         and y along the base line towards the front plate, the contact side.";
    base_width_mm: Number(LENGTH, POSITIVE), Required, "Distance between the clamped ends of the plates.";
    front_length_mm: Number(LENGTH, POSITIVE), Required, "Length of the front plate, the contact side.";
    back_length_mm: Number(LENGTH, POSITIVE), Required, "Length of the back plate.";
    depth_mm: Number(LENGTH, POSITIVE), Required, "Depth of all strips, out of the plane.";
    rod_arm_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0), "Rigid arms at both ends of every member.";
    poissons_ratio: Number(Quantity("ratio", ""), Above(-1.0, 0.5)), Or(0.0),
        "Poisson's ratio nu: the modulus is E / (1 - nu^2), as of strips much wider than thick.";
}

tables! {
    FRONT = "finger.front", BACK = "finger.back": PlateKeys, Once, "A plate.";
    thickness_mm: Number(LENGTH, POSITIVE), Required, "Thickness; of a plate that tapers, at the base.";
    tip_thickness_mm: Number(LENGTH, POSITIVE), Optional,
        "Thickness at the tip of a plate that tapers linearly. Objects touch front plates of one thickness alone.";
    youngs_modulus_mpa: Number(MODULUS, POSITIVE), Required, "Young's modulus E.";
    largest_strain: Number(STRAIN, Above(0.0, 1.0)), Optional,
        "Largest fibre strain up to which the material is linear; a larger one gives a warning. Without it 0.05.";
    rigid_base_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0), "Length next to the base that does not bend.";
    rigid_tip_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0), "Length next to the tip that does not bend.";
}

tables! {
    RIBS = "finger.ribs": RibKeys, Once, "The ribs.";
    count: Count("ribs", 0, 1000), RequiredIf("unless positions_mm is there"), "Number of ribs, evenly spaced.";
    positions_mm: Pairs("[front, back], positions in mm", None), Optional,
        "Instead of count: where each rib meets front and back plate, from the base; 0 is the corner of the base. Ribs may share a junction, and do not cross.";
    joints: Word<2>(["rigid", "hinged"]), RequiredIf("unless there are no ribs"), "How ribs are joined to the plates: hinged ones have a pin at both ends.";
    rigid: Word<2>(TRUE_FALSE), Or(1), "Whether ribs do not deform.";
    thickness_mm: RibNumbers(Number(LENGTH, POSITIVE)), RequiredIf("unless ribs are rigid"), "Thickness.";
    youngs_modulus_mpa: Number(MODULUS, POSITIVE), RequiredIf("unless ribs are rigid"), "Young's modulus E.";
    largest_strain: Number(STRAIN, Above(0.0, 1.0)), Optional, "Largest fibre strain, as of the plates.";
    bracket_mm: RibLengths(), Or(BracketLengths::NONE),
        "Rigid brackets that hold the joints off the plates, perpendicular to them and inwards.";
    clip_mm: SideLengths(), Or([0.0; 2]), "Length of plate about each rib's end that does not bend.";
}

tables! {
    ZONE = "finger.zone": ZoneKeys, Many,
        "A softer or stiffer section. Zones that overlap multiply. An element's compliance is the mean of 1 / factor over its length.";
    plate: Word<3>(["front", "back", "ribs"]), Required, "Where it is; for ribs: those whose front end lies in it.";
    from_mm: Number(POSITION, ByOthers("on the plate")), Required, "Where it begins along the plate, from the base.";
    to_mm: Number(POSITION, ByOthers("after from_mm")), Required, "Where it ends.";
    modulus_factor: Number(Quantity("factor", ""), POSITIVE), Required, "Factor on Young's modulus there.";
}

tables! {
    ASSEMBLY = "assembly": AssemblyKeys, Optional,
        "By how much the unloaded finger may differ from the tables above since it was assembled or mounted. `finray sense` estimates that with the \
         force, and sigma_n holds it; `finray calibrate` finds the preload. Nothing else uses this table.";
    joint_sigma_mm: Number(Quantity(SIGMA, "mm"), Within(0.0, LARGEST_JOINT_SIGMA_MM)), Or(0.0),
        "Standard deviation of where each joint of a rib is, along its plate and perpendicular to it.";
    preload_nmm: Number(Quantity("moment", "N mm"), Finite), Or(0.0),
        "Moment at the tip that the plates exert on each other without load, from x to y, as evenly curved plates leave. `finray calibrate` writes it.";
    preload_sigma_nmm: Number(Quantity(SIGMA, "N mm"), NOT_NEGATIVE), Or(0.0), "Standard deviation of that moment. `finray calibrate` writes it.";
    height_sigma_mm: Number(Quantity(SIGMA, "mm"), NOT_NEGATIVE), Or(0.0),
        "Standard deviation of the markers' height before the camera: finger and markers then appear larger or smaller.";
    errors: Rows("of one error each"), Optional,
        "Errors that a calibration leaves, independent of each other, one row each, of one standard deviation: of each rib how far its joints are off on the \
         front plate, along it and into the finger, and on the back plate (mm); then clips on front and back plate (mm), preload (N mm), height of the \
         markers (mm), base x and y (mm) and turn (degrees). `finray calibrate` writes it where no modulus is sought.";
}

tables! {
    CAMERA = "camera": CameraKeys, Optional, "The camera: its noise alone, or its lens and pose as well.";
    noise_mm: Number(LENGTH, NOT_NEGATIVE), RequiredIf("unless keys of the lens are there"),
        "Standard deviation of one displacement coordinate, and of one of an outline point for `finray press`.";
    size_px: Numbers<2>(Quantity("width and height", "px"), Whole(1.0, 65_535.0)), RequiredIf("for images"),
        "Size of the images. Pixel (0, 0) has its centre at (0, 0); u points to the right, v down.";
    focal_px: Numbers<2>(Quantity("focal lengths along u and v", "px"), Within(1e-3, LONGEST_FOCUS_PX)),
        RequiredIf("for images"), "Focal lengths.";
    principal_point_px: Numbers<2>(Quantity("u and v", "px"), AtMost(LONGEST_FOCUS_PX)), RequiredIf("for images"),
        "Pixel on the camera's axis.";
    distortion: Numbers<5>(Quantity("k1, k2, p1, p2, k3", ""), AtMost(1e6)), Or([0.0; 5]),
        "Coefficients of Brown and Conrady's distortion in OpenCV's convention. They must not fold the image.";
    rotation_vector_rad: Numbers<3>(Quantity("a rotation vector", "rad"), AtMost(100.0)), RequiredIf("with translation_mm"),
        "Rodrigues vector of R in X_camera = R X_finger + t. Without a pose `finray locate` needs --rest.";
    translation_mm: Numbers<3>(Quantity("a translation", "mm"), AtMost(FARTHEST_MM)), RequiredIf("with rotation_vector_rad"),
        "The translation t.";
}

tables! {
    MARKERS = "markers": MarkerKeys, Optional,
        "Markers on key nodes, the clamped ones included: discs of two colours, or discs and rings that are brighter or darker than their surroundings.";
    on: Word<2>(["junctions", "hinges"]), Or(0),
        "Where they are centred: on the junctions of plate and rib, or on the joints of ribs on brackets and nowhere else.";
    radius_mm: Number(LENGTH, Positive(LARGEST_MARKER_MM)), RequiredIf("for images"), "Radius; of a ring the outer one.";
    height_mm: Number(LENGTH, AtMost(LARGEST_MARKER_MM)), RequiredIf("for images"),
        "Height above the plane of the beams, along z = x cross y of the finger frame.";
    front_rgb: Numbers<3>(COLOUR, Whole(0.0, 255.0)), RequiredIf("for images, unless shade is there"),
        "Colour on the front plate, its clamped node and the tip included.";
    back_rgb: Numbers<3>(COLOUR, Whole(0.0, 255.0)), RequiredIf("for images, unless shade is there"), "Colour on the back plate.";
    shade: Word<2>(["bright", "dark"]), RequiredIf("with inner_radius_mm"),
        "Instead of colours: brightness against the surroundings in grey light. Markers are found by their rims.";
    inner_radius_mm: Number(LENGTH, BELOW_RADIUS), Or(0.0),
        "Inner radius of rings; only with shade. Inside it a marker may look like anything.";
    noise_factor: Number(Quantity("number", ""), Above(0.0, 1.0)), Or(1.0),
        "Scales the noise that `finray locate` states. `finray calibrate` writes it.";
    model_error_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0),
        "By how much the finger misses its markers; part of every sigma_n. `finray calibrate` writes it.";
}

tables! {
    BASE = "base": BaseKeys, Optional,
        "A base that is elsewhere in each image, for markers with a shade. With standard deviations `finray sense` estimates the base, too.";
    sigma_mm: Number(LENGTH, NOT_NEGATIVE), RequiredIf("with any other key of the table"),
        "Standard deviation of each coordinate of the base about where the references have it; without references about the camera's pose.";
    sigma_deg: Number(ANGLE, Within(0.0, 90.0)), RequiredIf("with any other key of the table"), "Standard deviation of its turn.";
    turn_deg_per_n: Number(TURN, Within(-LARGEST_TURN, LARGEST_TURN)), Or(0.0),
        "Expected turn of the base with the force, from x to y, where no references show it. `finray calibrate` writes it.";
    turn_sigma_deg_per_n: Number(TURN, Within(0.0, LARGEST_TURN)), Or(0.0),
        "Standard deviation of that turn. `finray calibrate` writes it.";
}

tables! {
    REFERENCE = "base.reference": ReferenceKeys, Many, "A mark on the base. Two or more show where the base is.";
    at_mm: Numbers<2>(Quantity("x and y", "mm"), AtMost(FARTHEST_MM)), Required, "Its centre in the finger frame.";
    radius_mm: Number(LENGTH, Positive(LARGEST_MARKER_MM)), Required, "Radius; of a ring the outer one.";
    height_mm: Number(LENGTH, AtMost(LARGEST_MARKER_MM)), Required, "Height above the plane of the beams.";
    shade: Word<2>(["bright", "dark"]), Required, "Brightness against the surroundings.";
    inner_radius_mm: Number(LENGTH, BELOW_RADIUS), Or(0.0), "Inner radius of a ring.";
}

tables! {
    CONTACT = "contact": ContactKeys, Optional, "How objects meet the finger.";
    rod_radius_mm: Number(LENGTH, NOT_NEGATIVE), Or(ROD_RADIUS_MM),
        "Radius of the rods at the key nodes of the front plate, which a pressed or grasped object meets.";
    friction: Number(FRICTION, Within(-LARGEST_FRICTION, LARGEST_FRICTION)), Optional,
        "Forces sensed with the direction `friction` lean from the normal by its arctangent, positive towards the tip.";
    friction_sigma: Number(Quantity(SIGMA, ""), Within(0.0, LARGEST_FRICTION)), Or(0.0), "Standard deviation of friction.";
    friction_range: Numbers<2>(Quantity("the least and the largest coefficient of friction", ""), Within(-LARGEST_FRICTION, LARGEST_FRICTION)), Optional,
        "Instead of friction: each coefficient between the two is as likely as the others.";
    friction_build_up_n: Number(FORCE, NOT_NEGATIVE), Or(0.0),
        "At a force F the lean is 1 - exp(-F / friction_build_up_n) of the whole; all of it where this is 0.";
    normal: Word<2>(["deformed", "undeformed"]), Or(0), "Which plate's normal the force leans from.";
    normal_over_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0),
        "Length of plate over which the deformed normal is averaged.";
    pad_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0),
        "How far before the plate an object touches, as on a pad; friction there turns the plate. For forces that `finray sense` and \
         `finray calibrate` estimate; at most the length of the front plate, as pad_length_mm.";
    pad_length_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0), "Length of plate over which the pad spreads a force.";
    force_error_share: Number(Quantity("share", ""), Within(0.0, 1.0)), Or(0.0),
        "Relative standard deviation of a force beyond all else; part of every sigma_n. `finray calibrate` writes it.";
}

tables! {
    TOUCHED = "contact.object": TouchedKeys, Optional,
        "A convex object of known shape that touches the front plate where a force with the direction `object` is sensed.";
    shape: Word<3>(["disc", "ellipse", "polygon"]), Required, "Its outline.";
    radius_mm: Number(LENGTH, Positive(LARGEST)), Of("disc"), "Radius.";
    semi_axes_mm: Numbers<2>(Quantity("lengths", "mm"), Positive(LARGEST)), Of("ellipse"), "Half of each axis.";
    corners_mm: Pairs("[x, y], corners in mm", Some(("corners", LARGEST))), Of("polygon"),
        "Corners of a convex polygon in order, one of which touches.";
    pose_mm: Numbers<2>(Quantity("x and y", "mm"), AtMost(LARGEST)), RequiredIf("with any key below"),
        "Where the origin of its outline is. Without it only tangency of plate and outline is assumed.";
    pose_sigma_mm: Number(Quantity(SIGMA, "mm"), Within(0.0, LARGEST)), RequiredIf("with pose_mm"),
        "Standard deviation of each coordinate of the pose; 0 takes the pose for exact.";
    rotation_deg: Number(ANGLE, Finite), Or(0.0), "By how much the outline is turned from x to y; not of a disc.";
    rotation_sigma_deg: Number(Quantity(SIGMA, "degrees"), Within(0.0, LARGEST)), Or(0.0), "Standard deviation of rotation_deg; not of a disc.";
    frame: Word<2>(["base", "plane"]), Or(0),
        "Frame of the pose: the finger frame where the image has its base, or the frame of the camera's pose.";
}

tables! {
    OBJECT = "object": ObjectKeys, Optional,
        "The object that `finray press` presses onto the finger, or that `finray grasp` grasps. One that is pressed has at_mm with travel_mm or \
         force_n, or path_mm; one that is grasped has mass_g and centre_mm.";
    shape: Word<3>(["disc", "box", "polygon"]), Required, "Its outline.";
    radius_mm: Number(LENGTH, Positive(LARGEST)), Of("disc"), "Radius.";
    width_mm: Number(LENGTH, Positive(LARGEST)), Of("box"), "Side along x before it is turned.";
    height_mm: Number(LENGTH, Positive(LARGEST)), Of("box"), "Side along y before it is turned.";
    points_csv: Text(), Of("polygon"), "File beside the scene with the corners in order, in columns x_mm,y_mm.";
    rotation_deg: Number(ANGLE, Finite), Or(0.0), "By how much the outline is turned from x to y.";
    friction: Number(FRICTION, Within(0.0, LARGEST_FRICTION)), Or(0.0),
        "Coulomb's coefficient of friction against fingers and support.";
    at_mm: Number(POSITION, ByOthers("on the front plate")), RequiredIf("for `finray press`, unless path_mm is there"),
        "Where the line that it moves on meets the front plate, from the base. The object starts where it just touches.";
    direction_deg: Number(ANGLE, Between(-90.0, 90.0)), Or(0.0),
        "Angle of that line from the undeformed inward normal, positive towards the tip.";
    travel_mm: Number(LENGTH, Positive(LARGEST)), RequiredIf("with at_mm, unless force_n is there"), "How far it moves from first touch.";
    force_n: Number(FORCE, Positive(LARGEST)), Optional,
        "Instead of travel_mm: the force along the line up to which it moves; across the line it is guided.";
    path_mm: Pairs("[x, y], points of the finger frame in mm", Some(("two or more different points [x, y]", LARGEST))), Optional,
        "Instead of at_mm: points that its centre moves through, of a polygon its origin.";
    steps: Count("", 1, MOST_STEPS), Or(20), "Equal steps of a press.";
    mass_g: Number(Quantity("mass", "g"), Positive(LARGEST)), RequiredIf("for `finray grasp`"),
        "Mass of a free object. Its centre of mass is the centre of its area.";
    centre_mm: Numbers<2>(Quantity("x and y", "mm"), AtMost(LARGEST)), RequiredIf("for `finray grasp`"),
        "Where its point (a disc's or box's centre, a polygon's origin) is at first, in the frame of [grasp].";
}

tables! {
    GRIPPER = "gripper": GripperKeys, Optional,
        "The linkage that moves two mirrored fingers, for `finray gripper` and `finray grasp` (Xu et al. 2021, eqs 6-9).";
    screw_pitch_mm: Number(LENGTH, Positive(LARGEST)), Required, "Way of the nut in one turn of the motor.";
    slider_mm: Number(Quantity("height", "mm"), AtMost(LARGEST)), Required, "Height of the nut at motor angle 0.";
    link_mm: Numbers<2>(Quantity("lengths", "mm"), Positive(LARGEST)), Required,
        "Lengths of rocker and link, which meet at the finger's base.";
    fixed_joint_mm: Number(LENGTH, Positive(LARGEST)), Required, "Distance of the rocker's fixed joint from the screw's axis.";
    assembly: Word<2>(["outer", "inner"]), Or(0),
        "Whether rocker and link meet at the point farther from the screw's axis, or nearer.";
}

tables! {
    GRASP = "grasp": GraspKeys, Optional,
        "What `finray grasp` does to the object. The frame is that of the gripper where it starts: its origin lies on the screw's axis at the height of \
         the fixed joints, x points to the right finger, y along the screw to the fingertips.";
    // Steps and speed of the motor: Xu et al. 2021, secs V-C and V-D.
    motor_deg: Numbers<2>(Quantity("motor angles", "degrees"), Finite), Required,
        "Where the motor starts, and where it stops at the latest; both within reach of the linkage.";
    step_deg: Number(Quantity("motor angle", "degrees"), Positive(LARGEST)), Or(22.5),
        "Motor angle between two settled steps; not with frames_per_s.";
    until_force_n: Number(FORCE, Positive(LARGEST)), Optional,
        "Close until this total of a finger is sensed, the mean of both.";
    hold: Word<2>(TRUE_FALSE), Or(1), "Whether the motor goes on to hold that total on the way; only with until_force_n.";
    path_mm: Pairs("[x, y], points in mm from where the gripper starts", Some(("points", LARGEST))), Optional,
        "The gripper's way from where it starts.";
    path_steps: Count("", 1, MOST_STEPS), Or(10), "Settled steps on that way.";
    open: Word<2>(TRUE_FALSE), Optional, "Whether it opens at the end; without this key it does if it has a path.";
    support: Word<3>(["true", "false", "table"]), Optional,
        "What the object lies on at first. true: rails before and behind the fingers, which pass between them; \"table\": a plane that fingers must not \
         touch; false: nothing, and its weight acts once it is grasped. Without this key true, or false where gravity is zero.";
    gravity_m_s2: Numbers<2>(Quantity("gravity", "m/s^2"), AtMost(LARGEST)), Or([0.0, 9.81]),
        "Gravity, by default that on the ground for a gripper that points down.";
    motor_deg_per_s: Number(Quantity("speed", "degrees a second"), Positive(LARGEST)), Or(30.0), "Speed of the motor, for frames_per_s.";
    frames_per_s: Number(Quantity("rate", "frames a second"), Positive(LARGEST)), Optional,
        "Instead of step_deg: a settled step for each frame of the camera.";
    delay_frames: Count("", 0, MOST_STEPS), Or(0), "By how many frames sensing is late; only with frames_per_s.";
    camera_on_gripper: Word<2>(TRUE_FALSE), Or(1),
        "Whether, for --images, the pose of [camera] is that of the gripper's frame (eq. 10), and not of each finger's.";
}
