//! Every key of every table of a scene: kind and range of its values, default, and meaning.
// The texts name tables of a scene in brackets, which are not links.
#![allow(rustdoc::broken_intra_doc_links)]

use super::Need::{Of, Optional, Or, Required, RequiredIf};
use super::Range::{Above, AtMost, Between, ByOthers, Finite, Positive, Whole, Within};
use super::{
    BracketLengths, Count, Entry, Key, Number, Numbers, Occurs, Pairs, Quantity, Range, RibLengths, RibNumbers, Rows,
    SceneTable, SideLengths, Text, Word,
};

/// Default radius of the rods on the front plate, mm. The rods of Xu et al. (2021), sec. II, have a diameter of 3 mm.
pub const ROD_RADIUS_MM: f64 = 1.5;

const NOT_NEGATIVE: Range = Range::NOT_NEGATIVE;
const POSITIVE: Range = Range::POSITIVE;
/// Upper limit of the lengths of a linkage, object or path (mm), and of several other quantities, each in the unit of its key.
const LARGEST: f64 = 1e4;
/// Upper limit of the distance between finger and camera, mm.
const FARTHEST_MM: f64 = 1e5;
/// Upper limit of the size of a marker, mm.
const LARGEST_MARKER_MM: f64 = 1e3;
/// Upper limit of the focal length, px.
const LONGEST_FOCUS_PX: f64 = 1e7;
/// Upper limit of a coefficient of friction, dimensionless; rubber on rubber reaches 2.
const LARGEST_FRICTION: f64 = 10.0;
/// Upper limit of the base's rotation per force, degrees per N. A softer base does not hold a finger.
const LARGEST_TURN: f64 = 10.0;
/// Upper limit of the standard deviation of a joint's position, mm. A larger value means that the description does not match the finger.
const LARGEST_JOINT_SIGMA_MM: f64 = 10.0;
/// Upper limit of a number of steps or of camera frames.
const MOST_STEPS: usize = 10_000;

const BELOW_RADIUS: Range = ByOthers("zero or more and below radius_mm");
const LENGTH: Quantity = Quantity("length", "mm");
const POSITION: Quantity = Quantity("position", "mm");
const MODULUS: Quantity = Quantity("modulus", "MPa");
const ANGLE: Quantity = Quantity("angle", "degrees");
const TURN: Quantity = Quantity("angle", "degrees per newton");
const FORCE: Quantity = Quantity("force", "N");
const STRAIN: Quantity = Quantity("strain", "");
const FRICTION: Quantity = Quantity("coefficient of friction", "");
const SIGMA: &str = "standard deviation";
const TRUE_FALSE: [&str; 2] = ["true", "false"];
const COLOUR: Quantity = Quantity("red, green and blue", "");

/// Defines tables: a static per table with its path, and a struct with the keys that these tables share.
macro_rules! tables {
    ($($name:ident = $path:literal),+: $keys:ident, $occurs:ident, $about:literal;
     $($key:ident: $kind:ident $(<$n:literal>)? ($($value:tt)*), $need:expr, $says:literal;)*) => {
        #[doc = $about]
        #[derive(Debug)]
        pub struct $keys {
            path: &'static str,
            $(#[doc = $says] pub $key: Key<$kind $(<$n>)?>,)*
        }

        impl $keys {
            const fn of(path: &'static str) -> $keys {
                $keys {
                    path,
                    $($key: Key {
                        table: path,
                        name: stringify!($key),
                        kind: $kind $(::<$n>)? ($($value)*),
                        need: $need,
                        says: $says,
                    },)*
                }
            }
        }

        impl SceneTable for $keys {
            fn path(&self) -> &'static str { self.path }
            fn occurs(&self) -> Occurs { Occurs::$occurs }
            fn says(&self) -> &'static str { $about }
            fn entries(&self) -> Vec<Entry> {
                vec![$(self.$key.entry()),*]
            }
        }

        $(#[doc = $about]
        pub static $name: $keys = $keys::of($path);)+
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
        "The finger: two plates in a V, joined by ribs. Its frame has the origin at the middle of the base line, x towards the tip \
         and y along the base line towards the front plate, the contact side.";
    base_width_mm: Number(LENGTH, POSITIVE), Required, "Distance between the clamped ends of the plates.";
    front_length_mm: Number(LENGTH, POSITIVE), Required, "Length of the front plate, the contact side.";
    back_length_mm: Number(LENGTH, POSITIVE), Required, "Length of the back plate.";
    depth_mm: Number(LENGTH, POSITIVE), Required, "Depth of all strips, out of the plane.";
    rod_arm_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0), "Length of the rigid arms at both ends of every member.";
    poissons_ratio: Number(Quantity("ratio", ""), Above(-1.0, 0.5)), Or(0.0),
        "Poisson's ratio nu. The modulus is E / (1 - nu^2), for strips much wider than thick.";
}

tables! {
    FRONT = "finger.front", BACK = "finger.back": PlateKeys, Once, "A plate.";
    thickness_mm: Number(LENGTH, POSITIVE), Required, "Thickness; for a tapered plate, at the base.";
    tip_thickness_mm: Number(LENGTH, POSITIVE), Optional,
        "Thickness at the tip of a linearly tapered plate. Objects can only touch front plates of constant thickness.";
    youngs_modulus_mpa: Number(MODULUS, POSITIVE), Required, "Young's modulus E.";
    largest_strain: Number(STRAIN, Above(0.0, 1.0)), Optional,
        "Largest fibre strain at which the material is linear; a larger strain gives a warning. Without this key 0.05.";
    rigid_base_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0), "Rigid length at the base.";
    rigid_tip_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0), "Rigid length at the tip.";
}

tables! {
    RIBS = "finger.ribs": RibKeys, Once, "The ribs.";
    count: Count("ribs", 0, 1000), RequiredIf("unless positions_mm is there"), "Number of evenly spaced ribs.";
    positions_mm: Pairs("[front, back], positions in mm", None), Optional,
        "Instead of count: position of each rib on front and back plate, from the base; 0 is a corner of the base. Ribs may share a junction but not cross.";
    joints: Word<2>(["rigid", "hinged"]), RequiredIf("unless there are no ribs"), "Joints between ribs and plates: clamped (rigid) or pinned.";
    rigid: Word<2>(TRUE_FALSE), Or(1), "Whether ribs are undeformable.";
    thickness_mm: RibNumbers(Number(LENGTH, POSITIVE)), RequiredIf("unless ribs are rigid"), "Thickness.";
    youngs_modulus_mpa: Number(MODULUS, POSITIVE), RequiredIf("unless ribs are rigid"), "Young's modulus E.";
    largest_strain: Number(STRAIN, Above(0.0, 1.0)), Optional, "Largest fibre strain at which the material is linear, as for the plates.";
    bracket_mm: RibLengths(), Or(BracketLengths::NONE),
        "Lengths of the rigid brackets from the plates to the joints, perpendicular to the plates and inwards.";
    clip_mm: SideLengths(), Or([0.0; 2]), "Rigid length of the plate at each rib's end, half of it on either side.";
}

tables! {
    ZONE = "finger.zone": ZoneKeys, Many,
        "A softer or stiffer section. Factors of overlapping zones multiply. The mean of 1 / factor over an element's length scales its compliance.";
    plate: Word<3>(["front", "back", "ribs"]), Required, "Part of the finger; for ribs: those whose front end lies in the zone.";
    from_mm: Number(POSITION, ByOthers("on the plate")), Required, "Start along the plate, from the base.";
    to_mm: Number(POSITION, ByOthers("after from_mm")), Required, "End along the plate, from the base.";
    modulus_factor: Number(Quantity("factor", ""), POSITIVE), Required, "Factor on Young's modulus in the zone.";
}

tables! {
    ASSEMBLY = "assembly": AssemblyKeys, Optional,
        "Deviations of the unloaded finger from the tables above, from assembly or mounting. `finray sense` estimates them with the \
         force and includes them in sigma_n; `finray calibrate` estimates the preload. No other command uses this table.";
    joint_sigma_mm: Number(Quantity(SIGMA, "mm"), Within(0.0, LARGEST_JOINT_SIGMA_MM)), Or(0.0),
        "Standard deviation of each rib joint's position, along its plate and perpendicular to it.";
    preload_nmm: Number(Quantity("moment", "N mm"), Finite), Or(0.0),
        "Moment that the plates exert on each other at the tip without load, positive from x to y, as from curved plates. `finray calibrate` writes it.";
    preload_sigma_nmm: Number(Quantity(SIGMA, "N mm"), NOT_NEGATIVE), Or(0.0), "Standard deviation of preload_nmm. `finray calibrate` writes it.";
    height_sigma_mm: Number(Quantity(SIGMA, "mm"), NOT_NEGATIVE), Or(0.0),
        "Standard deviation of the markers' height; an error of it scales the finger and its markers in the image.";
    errors: Rows("of one error each"), Optional,
        "Independent errors that remain after a calibration, one row each, of one standard deviation. For each rib: offset of its joint on the \
         front plate, along it and into the finger, and on the back plate (mm). Then: clips on front and back plate (mm), preload (N mm), height of the \
         markers (mm), base x and y (mm) and rotation (degrees). `finray calibrate` writes it unless it estimates a modulus.";
}

tables! {
    CAMERA = "camera": CameraKeys, Optional, "The camera: its noise only, or its lens and pose as well.";
    noise_mm: Number(LENGTH, NOT_NEGATIVE), RequiredIf("unless keys of the lens are there"),
        "Standard deviation of each displacement coordinate; for `finray press`, also of each coordinate of an outline point.";
    size_px: Numbers<2>(Quantity("width and height", "px"), Whole(1.0, 65_535.0)), RequiredIf("for images"),
        "Size of the images. Pixel (0, 0) has its centre at (0, 0); u points to the right, v down.";
    focal_px: Numbers<2>(Quantity("focal lengths along u and v", "px"), Within(1e-3, LONGEST_FOCUS_PX)),
        RequiredIf("for images"), "Focal lengths.";
    principal_point_px: Numbers<2>(Quantity("u and v", "px"), AtMost(LONGEST_FOCUS_PX)), RequiredIf("for images"),
        "Principal point: the pixel on the optical axis.";
    distortion: Numbers<5>(Quantity("k1, k2, p1, p2, k3", ""), AtMost(1e6)), Or([0.0; 5]),
        "Brown-Conrady distortion coefficients in OpenCV's convention. They must not fold the image.";
    rotation_vector_rad: Numbers<3>(Quantity("a rotation vector", "rad"), AtMost(100.0)), RequiredIf("with translation_mm"),
        "Rodrigues vector of R in X_camera = R X_finger + t. Without a pose `finray locate` needs --rest.";
    translation_mm: Numbers<3>(Quantity("a translation", "mm"), AtMost(FARTHEST_MM)), RequiredIf("with rotation_vector_rad"),
        "Translation t in X_camera = R X_finger + t.";
}

tables! {
    MARKERS = "markers": MarkerKeys, Optional,
        "Markers on the key nodes, including the clamped ones: discs of two colours, or discs and rings brighter or darker than their surroundings.";
    on: Word<2>(["junctions", "hinges"]), Or(0),
        "Centres of the markers: the junctions of plates and ribs, or only the joints of ribs on brackets.";
    radius_mm: Number(LENGTH, Positive(LARGEST_MARKER_MM)), RequiredIf("for images"), "Radius; for a ring, the outer radius.";
    height_mm: Number(LENGTH, AtMost(LARGEST_MARKER_MM)), RequiredIf("for images"),
        "Height above the plane of the beams, along z = x cross y of the finger frame.";
    front_rgb: Numbers<3>(COLOUR, Whole(0.0, 255.0)), RequiredIf("for images, unless shade is there"),
        "Colour of markers on the front plate, including its clamped node and the tip.";
    back_rgb: Numbers<3>(COLOUR, Whole(0.0, 255.0)), RequiredIf("for images, unless shade is there"), "Colour of markers on the back plate.";
    shade: Word<2>(["bright", "dark"]), RequiredIf("with inner_radius_mm"),
        "Instead of colours: brightness relative to the surroundings. Markers are found by their rims.";
    inner_radius_mm: Number(LENGTH, BELOW_RADIUS), Or(0.0),
        "Inner radius of rings; only with shade. The area inside may have any appearance.";
    noise_factor: Number(Quantity("number", ""), Above(0.0, 1.0)), Or(1.0),
        "Factor on the marker noise that `finray locate` states. `finray calibrate` writes it.";
    model_error_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0),
        "Standard deviation of the error of the finger model at a marker coordinate; included in sigma_n. `finray calibrate` writes it.";
}

tables! {
    BASE = "base": BaseKeys, Optional,
        "A base that moves between images; for markers with a shade. With standard deviations, `finray sense` also estimates the base.";
    sigma_mm: Number(LENGTH, NOT_NEGATIVE), RequiredIf("with any other key of the table"),
        "Standard deviation of each base coordinate, relative to the references or, without references, to the camera's pose.";
    sigma_deg: Number(ANGLE, Within(0.0, 90.0)), RequiredIf("with any other key of the table"), "Standard deviation of the base's rotation.";
    turn_deg_per_n: Number(TURN, Within(-LARGEST_TURN, LARGEST_TURN)), Or(0.0),
        "Expected rotation of the base per unit of force, positive from x to y, if no references show it. `finray calibrate` writes it.";
    turn_sigma_deg_per_n: Number(TURN, Within(0.0, LARGEST_TURN)), Or(0.0),
        "Standard deviation of turn_deg_per_n. `finray calibrate` writes it.";
}

tables! {
    REFERENCE = "base.reference": ReferenceKeys, Many, "A mark on the base. Two or more marks determine the base's pose.";
    at_mm: Numbers<2>(Quantity("x and y", "mm"), AtMost(FARTHEST_MM)), Required, "Centre in the finger frame.";
    radius_mm: Number(LENGTH, Positive(LARGEST_MARKER_MM)), Required, "Radius; for a ring, the outer radius.";
    height_mm: Number(LENGTH, AtMost(LARGEST_MARKER_MM)), Required, "Height above the plane of the beams.";
    shade: Word<2>(["bright", "dark"]), Required, "Brightness relative to the surroundings.";
    inner_radius_mm: Number(LENGTH, BELOW_RADIUS), Or(0.0), "Inner radius of a ring.";
}

tables! {
    CONTACT = "contact": ContactKeys, Optional, "Contact between objects and the finger.";
    rod_radius_mm: Number(LENGTH, NOT_NEGATIVE), Or(ROD_RADIUS_MM),
        "Radius of the rods at the key nodes of the front plate; pressed and grasped objects touch them.";
    friction: Number(FRICTION, Within(-LARGEST_FRICTION, LARGEST_FRICTION)), Optional,
        "Coefficient of friction. A force with the direction `friction` deviates from the normal by its arctangent, positive towards the tip.";
    friction_sigma: Number(Quantity(SIGMA, ""), Within(0.0, LARGEST_FRICTION)), Or(0.0), "Standard deviation of friction.";
    friction_range: Numbers<2>(Quantity("the least and the largest coefficient of friction", ""), Within(-LARGEST_FRICTION, LARGEST_FRICTION)), Optional,
        "Instead of friction: two coefficients; all between them are equally likely.";
    friction_build_up_n: Number(FORCE, NOT_NEGATIVE), Or(0.0),
        "Force over which the deviation from the normal builds up: a force F has 1 - exp(-F / friction_build_up_n) of it; all of it for 0.";
    normal: Word<2>(["deformed", "undeformed"]), Or(0), "Normal of the deformed or undeformed plate, from which the force deviates by friction.";
    normal_over_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0),
        "Length of the plate over which the deformed normal is averaged.";
    pad_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0),
        "Thickness of a pad between plate and object; friction on the pad exerts a moment on the plate. For forces that `finray sense` and \
         `finray calibrate` estimate. At most the length of the front plate, like pad_length_mm.";
    pad_length_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0), "Length of the plate over which the pad distributes a force.";
    force_error_share: Number(Quantity("share", ""), Within(0.0, 1.0)), Or(0.0),
        "Relative standard deviation of a force from all other causes; included in sigma_n. `finray calibrate` writes it.";
}

tables! {
    TOUCHED = "contact.object": TouchedKeys, Optional,
        "A convex object of known shape that touches the front plate; for forces with the direction `object`.";
    shape: Word<3>(["disc", "ellipse", "polygon"]), Required, "Type of the outline.";
    radius_mm: Number(LENGTH, Positive(LARGEST)), Of("disc"), "Radius.";
    semi_axes_mm: Numbers<2>(Quantity("lengths", "mm"), Positive(LARGEST)), Of("ellipse"), "Semi-axes along x and y before rotation.";
    corners_mm: Pairs("[x, y], corners in mm", Some(("corners", LARGEST))), Of("polygon"),
        "Corners of a convex polygon in order; a corner touches the plate.";
    pose_mm: Numbers<2>(Quantity("x and y", "mm"), AtMost(LARGEST)), RequiredIf("with any key below"),
        "Position of the origin of the outline. Without it only tangency of plate and outline is assumed.";
    pose_sigma_mm: Number(Quantity(SIGMA, "mm"), Within(0.0, LARGEST)), RequiredIf("with pose_mm"),
        "Standard deviation of each coordinate of pose_mm; 0 for an exact pose.";
    rotation_deg: Number(ANGLE, Finite), Or(0.0), "Rotation of the outline, positive from x to y; not for a disc.";
    rotation_sigma_deg: Number(Quantity(SIGMA, "degrees"), Within(0.0, LARGEST)), Or(0.0), "Standard deviation of rotation_deg; not for a disc.";
    frame: Word<2>(["base", "plane"]), Or(0),
        "Frame of the pose: the finger frame at the base's position in the image, or the frame of the camera's pose.";
}

tables! {
    OBJECT = "object": ObjectKeys, Optional,
        "The object that `finray press` presses onto the finger, or that `finray grasp` grasps. A pressed object has at_mm with travel_mm or \
         force_n, or path_mm; a grasped object has mass_g and centre_mm.";
    shape: Word<3>(["disc", "box", "polygon"]), Required, "Type of the outline.";
    radius_mm: Number(LENGTH, Positive(LARGEST)), Of("disc"), "Radius.";
    width_mm: Number(LENGTH, Positive(LARGEST)), Of("box"), "Side along x before rotation.";
    height_mm: Number(LENGTH, Positive(LARGEST)), Of("box"), "Side along y before rotation.";
    points_csv: Text(), Of("polygon"), "File beside the scene with the corners in order, in columns x_mm,y_mm.";
    rotation_deg: Number(ANGLE, Finite), Or(0.0), "Rotation of the outline, positive from x to y.";
    friction: Number(FRICTION, Within(0.0, LARGEST_FRICTION)), Or(0.0),
        "Coefficient of Coulomb friction against fingers and support.";
    at_mm: Number(POSITION, ByOthers("on the front plate")), RequiredIf("for `finray press`, unless path_mm is there"),
        "Position on the front plate that the line of motion meets, from the base. The object starts at first touch.";
    direction_deg: Number(ANGLE, Between(-90.0, 90.0)), Or(0.0),
        "Angle of the line of motion from the undeformed inward normal, positive towards the tip.";
    travel_mm: Number(LENGTH, Positive(LARGEST)), RequiredIf("with at_mm, unless force_n is there"), "Travel of the object from first touch.";
    force_n: Number(FORCE, Positive(LARGEST)), Optional,
        "Instead of travel_mm: force along the line of motion at which the press ends. The object is guided across the line.";
    path_mm: Pairs("[x, y], points of the finger frame in mm", Some(("two or more different points [x, y]", LARGEST))), Optional,
        "Instead of at_mm: points on the path of its centre, or of its origin for a polygon.";
    steps: Count("", 1, MOST_STEPS), Or(20), "Number of equal steps of a press.";
    mass_g: Number(Quantity("mass", "g"), Positive(LARGEST)), RequiredIf("for `finray grasp`"),
        "Mass of a free object. Its centre of mass is the centroid of its area.";
    centre_mm: Numbers<2>(Quantity("x and y", "mm"), AtMost(LARGEST)), RequiredIf("for `finray grasp`"),
        "Initial position of its centre, or of its origin for a polygon, in the frame of [grasp].";
}

tables! {
    GRIPPER = "gripper": GripperKeys, Optional,
        "The linkage that moves two mirrored fingers, for `finray gripper` and `finray grasp` (Xu et al. 2021, eqs 6-9).";
    screw_pitch_mm: Number(LENGTH, Positive(LARGEST)), Required, "Travel of the nut in one revolution of the motor.";
    slider_mm: Number(Quantity("height", "mm"), AtMost(LARGEST)), Required, "Height of the nut at motor angle 0.";
    link_mm: Numbers<2>(Quantity("lengths", "mm"), Positive(LARGEST)), Required,
        "Lengths of rocker and link, which meet at the finger's base.";
    fixed_joint_mm: Number(LENGTH, Positive(LARGEST)), Required, "Distance of the rocker's fixed joint from the screw's axis.";
    assembly: Word<2>(["outer", "inner"]), Or(0),
        "Which of its two possible positions the joint of rocker and link has: the one farther from the screw's axis, or the nearer one.";
}

tables! {
    GRASP = "grasp": GraspKeys, Optional,
        "How `finray grasp` grasps the object. The frame is that of the gripper at the start: its origin lies on the screw's axis at the height of \
         the fixed joints, x points to the right finger, y along the screw to the fingertips.";
    // Steps and speed of the motor: Xu et al. 2021, secs V-C and V-D.
    motor_deg: Numbers<2>(Quantity("motor angles", "degrees"), Finite), Required,
        "Motor angles at the start and at the latest stop; both within reach of the linkage.";
    step_deg: Number(Quantity("motor angle", "degrees"), Positive(LARGEST)), Or(22.5),
        "Motor angle between two settled steps; not with frames_per_s.";
    until_force_n: Number(FORCE, Positive(LARGEST)), Optional,
        "Sensed total force of a finger, mean of both fingers, at which closing stops.";
    hold: Word<2>(TRUE_FALSE), Or(1), "Whether the motor keeps that force along the path; only with until_force_n.";
    path_mm: Pairs("[x, y], points in mm from where the gripper starts", Some(("points", LARGEST))), Optional,
        "Path of the gripper from its start.";
    path_steps: Count("", 1, MOST_STEPS), Or(10), "Number of settled steps along the path.";
    open: Word<2>(TRUE_FALSE), Optional, "Whether the gripper opens at the end; without this key, it opens if it has a path.";
    support: Word<3>(["true", "false", "table"]), Optional,
        "Support of the object at the start. true: rails before and behind the fingers, which pass between them; \"table\": a plane that fingers must not \
         touch; false: none, and its weight acts once it is grasped. Without this key true, or false if gravity is zero.";
    gravity_m_s2: Numbers<2>(Quantity("gravity", "m/s^2"), AtMost(LARGEST)), Or([0.0, 9.81]),
        "Acceleration of gravity in the frame of this table; the default is Earth's for a gripper that points down.";
    motor_deg_per_s: Number(Quantity("speed", "degrees per second"), Positive(LARGEST)), Or(30.0), "Speed of the motor, for frames_per_s.";
    frames_per_s: Number(Quantity("rate", "frames per second"), Positive(LARGEST)), Optional,
        "Instead of step_deg: one settled step per frame of the camera.";
    delay_frames: Count("", 0, MOST_STEPS), Or(0), "Delay of sensing in frames; only with frames_per_s.";
    camera_on_gripper: Word<2>(TRUE_FALSE), Or(1),
        "For --images: whether the pose of [camera] is that of the gripper's frame (eq. 10) rather than of each finger's frame.";
}
