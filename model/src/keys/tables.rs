//! All keys of all tables of a scene. Each key has the kind and range of its values, its default and its meaning.
// The documentation of the keys writes names of tables in brackets. These brackets are not links.
#![allow(rustdoc::broken_intra_doc_links)]

use super::Need::{Of, Optional, Or, Required, RequiredIf};
use super::Range::{Above, AtMost, Between, ByOthers, Finite, Positive, Whole, Within};
use super::{
    BracketLengths, Count, Entry, Key, Number, NumberList, Numbers, Occurs, Pairs, Quantity, Range, RibLengths,
    RibNumbers, Rows, SceneTable, SideLengths, Text, Word,
};

/// Default radius of the rods on the front plate, mm. The source is section II of Xu et al. (2021). The rods of Xu et al. have a diameter of 3 mm.
pub const ROD_RADIUS_MM: f64 = 1.5;

const NOT_NEGATIVE: Range = Range::NOT_NEGATIVE;
const POSITIVE: Range = Range::POSITIVE;
/// Upper limit of lengths of linkages, objects and paths, mm. Several other quantities have the same limit, in the unit of their key.
const LARGEST: f64 = 1e4;
/// Upper limit of the distance between finger and camera, mm.
const FARTHEST_MM: f64 = 1e5;
/// Upper limit of the size of a marker, mm.
const LARGEST_MARKER_MM: f64 = 1e3;
/// Upper limit of the focal length, px.
const LONGEST_FOCUS_PX: f64 = 1e7;
/// Upper limit of a coefficient of friction, dimensionless. Rubber on rubber reaches 2.
const LARGEST_FRICTION: f64 = 10.0;
/// Upper limit of the base's rotation per force, degrees per N. A base that rotates more cannot support a finger.
const LARGEST_TURN: f64 = 10.0;
/// Upper limit of the standard deviation of a joint's position, mm. A larger value means that the description does not match the finger.
const LARGEST_JOINT_SIGMA_MM: f64 = 10.0;
/// Upper limit of numbers of steps and numbers of camera frames.
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

/// Defines tables that share their keys: one struct with these keys, and one static variable per table with the table's path.
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
    TOP = "": TopKeys, Once, "Keys at the top of the file, before the first table.";
    name: Text(), Required, "Name of the scene.";
}

tables! {
    FINGER = "finger": FingerKeys, Once,
        "The finger: two plates in a V, joined by ribs. The finger frame has its origin at the middle of the base line. Its x axis points to the \
         tip; its y axis points along the base line to the front plate. Objects touch the front plate.";
    base_width_mm: Number(LENGTH, POSITIVE), Required, "Distance between the clamped ends of the plates.";
    front_length_mm: Number(LENGTH, POSITIVE), Required, "Length of the front plate, which objects touch.";
    back_length_mm: Number(LENGTH, POSITIVE), Required, "Length of the back plate.";
    depth_mm: Number(LENGTH, POSITIVE), Required, "Depth of plates and ribs, perpendicular to the plane of the finger frame.";
    rod_arm_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0),
        "Length of the rigid arm at each end of each member. Members are the ribs and the segments of plates between nodes.";
    rib_arm_mm: Number(LENGTH, NOT_NEGATIVE), Optional, "Length of the rigid arm at each end of each rib. Default: rod_arm_mm.";
    clamp_arm_mm: Number(LENGTH, NOT_NEGATIVE), Optional,
        "Length of the rigid arm of each member at a clamped node. Default: the arm at the member's other end.";
    fillet_mm: Number(LENGTH, NOT_NEGATIVE), Optional,
        "Radius of the fillets in all corners of a finger of one piece, for instance printed or moulded; 0 for sharp corners. The arms of all \
         members then follow from thicknesses, angles and fillets, and rod_arm_mm, rib_arm_mm and clamp_arm_mm are not allowed. Not for fingers with rods in their junctions, hinges or brackets.";
    base_fillet_mm: Number(LENGTH, NOT_NEGATIVE), Optional, "Radius of the fillets between plates and base. Default: fillet_mm, which is required.";
    poissons_ratio: Number(Quantity("ratio", ""), Above(-1.0, 0.5)), Or(0.0),
        "Poisson's ratio nu. The effective modulus is E / (1 - nu^2) (plane strain), which is too stiff \
         for side faces that are free: for nu near 0.45, by 21, 14, 9, 7, 5 and 3 % on average at depths of 3, 6, 11, 16, 24 and 34 thicknesses (side_faces).";
    side_faces: Word<2>(["fixed", "free"]), Optional,
        "State of the two side faces. \"fixed\", the default: plane strain; without the key, commands warn if \"free\" would matter. \"free\": plates and ribs contract along the depth near the faces; needs poissons_ratio. \
         Rigidities then lie between those of plane strain (large depth) and those of plane stress with E (small depth), by the depth, the free length \
         and the thickness of each member. model_error then includes 0.005 for the error of this model (`finray guide your-finger`).";
    shear_correction: Number(Quantity("factor", ""), Within(0.0, 1.0)), Optional,
        "Shear correction factor kappa: plates and ribs have the shear rigidity kappa A E / (2 (1 + nu)). Use 5/6 for rectangular sections; 0 \
         means no shear deformation. Default: 5/6 with fillets, otherwise 0.";
    model_error: Number(Quantity("share", ""), Within(0.0, 1.0)), Optional,
        "Relative standard deviation of a sensed force due to the errors of beam theory. Every stated sigma_n includes this deviation, also in maps \
         and sweeps; their errors do not, because these follow from the true finger. `finray guide accuracy` states values. \
         Default: with fillets, and with stated arms beside poissons_ratio and shear_correction, the value for fingers of the same kind; otherwise 0.";
    youngs_modulus_sigma: Number(Quantity("share", ""), Within(0.0, 1.0)), Optional,
        "Relative standard deviation of a factor on all moduli; 0 for moduli that were measured on this finger. It scales all forces by one factor: \
         every sigma_n and every mean error of maps and sweeps includes it. \
         Default: 0.1 for a finger of plastic or rubber (a modulus below 10 000 MPa) that states fillets, or arms beside poissons_ratio and \
         shear_correction; otherwise 0. `finray calibrate` writes this key.";
    depth_sigma_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0),
        "Standard deviation of depth_mm, which scales all forces as youngs_modulus_sigma does. `finray calibrate` removes this key if it estimates a modulus.";
    thickness_sigma: Number(Quantity("share", ""), Within(0.0, 0.2)), Or(0.0),
        "Relative standard deviation of thickness_mm of the front plate, of the back plate and of the ribs: three independent factors, which change the shape \
         of the bent finger. `finray sense`, `finray live` and `finray setup --check` estimate them together with the force, and include them in sigma_n; \
         they then need the estimator `nonlinear` and the noise of the markers. Maps, sweeps and reports neglect this key. `finray setup` writes 0.02 for a printed finger.";
    modulus_per_thickness: Numbers<3>(Quantity("relative changes of the moduli", "per relative thickness of front plate, back plate and ribs"), AtMost(100.0)), Optional,
        "Relative change of all moduli per relative change of the thickness of front plate, back plate and ribs. A calibration under known loads determines \
         the product of moduli and thicknesses: of a plate that is thicker, it gives smaller moduli. `finray calibrate` writes this key if it estimates a modulus.";
}

tables! {
    FRONT = "finger.front", BACK = "finger.back": PlateKeys, Once, "A plate.";
    thickness_mm: Number(LENGTH, POSITIVE), Required, "Thickness of the plate; for a tapered plate, its thickness at the base.";
    tip_thickness_mm: Number(LENGTH, POSITIVE), Optional,
        "Thickness at the tip of a linearly tapered plate. Objects can touch only front plates of constant thickness.";
    fillet_mm: Number(LENGTH, NOT_NEGATIVE), Optional, "Radius of the fillets between this plate and the ribs. Default: finger.fillet_mm, which is required.";
    youngs_modulus_mpa: Number(MODULUS, POSITIVE), Required, "Young's modulus E of the plate.";
    largest_strain: Number(STRAIN, Above(0.0, 1.0)), Optional,
        "Largest fibre strain at which the material is linear. Default: 0.05. `finray solve`, `finray press` and, for a single image, `finray sense` warn of a larger strain.";
    rigid_base_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0), "Length of the rigid section at the base.";
    rigid_tip_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0), "Length of the rigid section at the tip.";
}

tables! {
    RIBS = "finger.ribs": RibKeys, Once, "The ribs.";
    count: Count("ribs", 0, 1000), RequiredIf("unless positions_mm is given"), "Number of evenly spaced ribs.";
    positions_mm: Pairs("[front, back], positions in mm", None), Optional,
        "Replaces count: position of each rib on the front and the back plate, measured from the base. Position 0 is the corner of the base. Ribs must not cross. Deformable ribs without brackets may share a junction.";
    joints: Word<2>(["rigid", "hinged"]), RequiredIf("if the finger has ribs"),
        "Joints between ribs and plates: clamped (`rigid`) or pinned (`hinged`).";
    rigid: Word<2>(TRUE_FALSE), Or(1), "Whether the ribs are undeformable.";
    thickness_mm: RibNumbers(Number(LENGTH, POSITIVE)), RequiredIf("unless ribs are rigid"), "Thickness of the ribs.";
    youngs_modulus_mpa: Number(MODULUS, POSITIVE), RequiredIf("unless ribs are rigid"), "Young's modulus E of the ribs.";
    largest_strain: Number(STRAIN, Above(0.0, 1.0)), Optional,
        "Largest fibre strain at which the material of the ribs is linear. Default and warning are the same as for plates.";
    fillet_mm: RibNumbers(Number(LENGTH, NOT_NEGATIVE)), Optional,
        "Radius of the fillets in the corners of the ribs, instead of those of plates. Default: finger.fillet_mm, which is required.";
    bracket_mm: RibLengths(), Or(BracketLengths::NONE),
        "Lengths of the rigid brackets, which connect plates and joints. Each bracket points inwards, perpendicular to its plate.";
    clip_mm: SideLengths(), Or([0.0; 2]),
        "Length of the rigid section of the plate at the end of each rib. Half of this length lies on each side of the rib.";
}

tables! {
    ZONE = "finger.zone": ZoneKeys, Many,
        "A softer or stiffer section of the finger. Factors of overlapping zones are multiplied. The compliance of an element is multiplied by the \
         mean of 1 / factor over the length of the element.";
    plate: Word<3>(["front", "back", "ribs"]), Required,
        "Part of the finger that contains the zone. A zone of ribs covers the ribs whose front end lies between from_mm and to_mm.";
    from_mm: Number(POSITION, ByOthers("on the plate")), Required,
        "Start of the zone, measured from the base along the plate; for ribs, along the front plate.";
    to_mm: Number(POSITION, ByOthers("after from_mm")), Required, "End of the zone, measured like from_mm.";
    modulus_factor: Number(Quantity("factor", ""), POSITIVE), Required, "Young's modulus is multiplied by this factor in the zone.";
}

tables! {
    ASSEMBLY = "assembly": AssemblyKeys, Optional,
        "Deviations of the unloaded finger from its description in the scene, caused by assembly or mounting. \
            With the estimator `nonlinear`, `finray sense` and `finray live` estimate the deviations together with the force, and include them in sigma_n. Other estimators and contacts with +-SD refuse this table. `finray calibrate --located` uses preload_nmm and can estimate it. `finray solve` ignores this table.";
    joint_sigma_mm: Number(Quantity(SIGMA, "mm"), Within(0.0, LARGEST_JOINT_SIGMA_MM)), Or(0.0),
        "Standard deviation of the position of each rib joint: along the joint's plate, and for joints on brackets also perpendicular to the plate. Ribs with a common junction move together.";
    preload_nmm: Number(Quantity("moment", "N mm"), Finite), Or(0.0),
        "Moment that the plates of the unloaded finger exert on each other at the tip, positive from x to y. Curved plates, for instance, cause \
         such a moment. `finray calibrate` writes this key.";
    preload_sigma_nmm: Number(Quantity(SIGMA, "N mm"), NOT_NEGATIVE), Or(0.0),
        "Standard deviation of preload_nmm. `finray calibrate` removes this key if it estimates the preload, because other keys then include this deviation.";
    height_sigma_mm: Number(Quantity(SIGMA, "mm"), NOT_NEGATIVE), Or(0.0),
        "Standard deviation of the markers' height; a height error scales the finger and its markers in the image. Without the camera's pose, or without a description of the markers in images, this key has no effect.";
    errors: Rows("of one error each"), Optional,
        "Independent errors that remain after a calibration. Each row describes one error with the size of one standard deviation. A row begins \
         with four numbers for each rib (mm): offset of the front joint along its plate and into the finger, then the same offsets of the back \
         joint. Seven numbers follow, for the errors of front and back clips (mm), preload (N mm), height of the markers (mm), x and y of the base \
         (mm), and rotation of the base (degrees). `finray calibrate` writes this key unless a modulus is estimated.";
}

tables! {
    CAMERA = "camera": CameraKeys, Optional, "The camera: its noise, lens and pose. Without images, noise_mm is enough.";
    noise_mm: Number(LENGTH, NOT_NEGATIVE), RequiredIf("unless keys of the lens are given"),
        "Standard deviation of the noise in each coordinate of a displacement. `finray press` and `finray grasp` add the same noise to each \
         coordinate of an outline point.";
    size_px: Numbers<2>(Quantity("width and height", "px"), Whole(1.0, 65_535.0)), RequiredIf("for images"),
        "Size of the images. The centre of pixel (0, 0) has the coordinates (0, 0); u points right, and v points down.";
    focal_px: Numbers<2>(Quantity("focal lengths along u and v", "px"), Within(1e-3, LONGEST_FOCUS_PX)),
        RequiredIf("for images"), "Focal lengths of the lens.";
    principal_point_px: Numbers<2>(Quantity("u and v", "px"), AtMost(LONGEST_FOCUS_PX)), RequiredIf("for images"),
        "Principal point: the pixel on the optical axis.";
    distortion_model: Word<2>(["brown-conrady", "fisheye"]), Or(0),
        "Distortion of the lens: the polynomial or rational model of Brown and Conrady, or OpenCV's fisheye model (in ROS: equidistant).";
    distortion: NumberList(Quantity("k1, k2, p1, p2 and, optionally, k3 or k3, k4, k5, k6; for a fisheye lens, k1, k2, k3, k4", ""), AtMost(1e6)),
        Or(Vec::new()),
        "Distortion coefficients in OpenCV's convention; without coefficients, a lens of Brown and Conrady does not distort. A marker must not lie beyond \
         the radius at which the distortion folds the image.";
    rotation_vector_rad: Numbers<3>(Quantity("a rotation vector", "rad"), AtMost(100.0)), RequiredIf("with translation_mm"),
        "Rodrigues vector of the rotation R in X_camera = R X_finger + t. Images of the finger require R and t, except for `finray locate --rest` with coloured markers.";
    translation_mm: Numbers<3>(Quantity("a translation", "mm"), AtMost(FARTHEST_MM)), RequiredIf("with rotation_vector_rad"),
        "Translation t in X_camera = R X_finger + t.";
    pose_errors: Rows("of 6 numbers each"), Or(Vec::new()),
        "Independent errors of the pose. Each row is one standard deviation of one error: a rotation vector of the finger in the camera frame (rad), then a \
         translation (mm). They scale and shear the displacements of markers that were located in images. `finray sense` and `finray live` estimate \
         them together with the force, unless the scene has a table [base]. `finray setup` writes this key.";
}

tables! {
    MARKERS = "markers": MarkerKeys, Optional,
        "Markers on the key nodes, including the clamped nodes. Markers are discs of two colours, or discs or rings that are brighter or darker \
         than their surroundings.";
    on: Word<2>(["junctions", "hinges"]), Or(0),
        "Positions of the markers' centres: the nodes on the plates (`junctions`), or only the joints between brackets and ribs (`hinges`).";
    radius_mm: Number(LENGTH, Positive(LARGEST_MARKER_MM)), RequiredIf("for images"), "Radius of the disc, or outer radius of the ring.";
    height_mm: Number(LENGTH, AtMost(LARGEST_MARKER_MM)), RequiredIf("for images"),
        "Height of the markers above the xy plane of the finger frame, along z = x cross y.";
    front_rgb: Numbers<3>(COLOUR, Whole(0.0, 255.0)), RequiredIf("for images, unless shade is given"),
        "Colour of the markers on the front plate, from its clamped node to the tip.";
    back_rgb: Numbers<3>(COLOUR, Whole(0.0, 255.0)), RequiredIf("for images, unless shade is given"),
        "Colour of the markers on the back plate, except the tip.";
    shade: Word<2>(["bright", "dark"]), RequiredIf("with inner_radius_mm"),
        "Replaces the two colours: brightness of the markers relative to their surroundings. Such markers are located by their rims.";
    inner_radius_mm: Number(LENGTH, BELOW_RADIUS), Or(0.0),
        "Inner radius of rings; requires shade. The area inside a ring may have any appearance.";
    noise_factor: Number(Quantity("number", ""), Above(0.0, 1.0)), Or(1.0),
        "Factor on the stated marker noise in `finray sense` and `finray live`, also on noise_mm and --noise-mm. `finray calibrate` writes this key.";
    noise_factor_of_mm: Number(LENGTH, Positive(LARGEST_MARKER_MM)), Optional,
        "Noise (sigma_mm of `finray locate`) of the images from which noise_factor was calibrated. Noise beyond it, for instance of compressed frames, \
         is not reduced. `finray calibrate` writes this key.";
    model_error_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0),
        "Standard deviation of the finger model's error in each marker coordinate. sigma_n includes this error. `finray calibrate` writes this key.";
    offsets_mm: Pairs("[x, y] in mm, one for each key node in ascending order", Some(("offsets", LARGEST_MARKER_MM))), Optional,
        "Position of each marker of the unloaded finger relative to its node, along x and y of the finger frame. Without this key, markers are centred \
         on their nodes. `finray setup` writes this key.";
    missing_nodes: NumberList(Quantity("node numbers", ""), Whole(1.0, 1000.0)), Or(Vec::new()),
        "Nodes whose markers are missing in the image from which offsets_mm are. Their distances from their nodes are unknown, so that images that show \
         them do not count them. `finray setup` writes this key.";
}

tables! {
    BASE = "base": BaseKeys, Optional,
        "A base that moves between images. References require markers with shade; with coloured markers, references have no effect. If this table has standard deviations, `finray sense` and `finray live` with the estimator `nonlinear` also estimate the pose of the base.";
    sigma_mm: Number(LENGTH, NOT_NEGATIVE), RequiredIf("with any other key of the table"),
        "Standard deviation of each coordinate of the base. The coordinates are relative to the references or, without references, to the camera's \
         pose.";
    sigma_deg: Number(ANGLE, Within(0.0, 90.0)), RequiredIf("with any other key of the table"), "Standard deviation of the base's rotation.";
    turn_deg_per_n: Number(TURN, Within(-LARGEST_TURN, LARGEST_TURN)), Or(0.0),
        "Expected rotation of the base per newton of contact force, positive from x to y; used only without references. `finray calibrate` writes \
         this key.";
    turn_sigma_deg_per_n: Number(TURN, Within(0.0, LARGEST_TURN)), Or(0.0),
        "Standard deviation of turn_deg_per_n. `finray calibrate` writes this key.";
}

tables! {
    REFERENCE = "base.reference": ReferenceKeys, Many, "A mark on the base. Two or more marks determine the pose of the base.";
    at_mm: Numbers<2>(Quantity("x and y", "mm"), AtMost(FARTHEST_MM)), Required, "Centre of the mark in the finger frame.";
    radius_mm: Number(LENGTH, Positive(LARGEST_MARKER_MM)), Required, "Radius of the disc, or outer radius of the ring.";
    height_mm: Number(LENGTH, AtMost(LARGEST_MARKER_MM)), Required, "Height of the mark above the xy plane of the finger frame.";
    shade: Word<2>(["bright", "dark"]), Required, "Brightness of the mark relative to its surroundings.";
    inner_radius_mm: Number(LENGTH, BELOW_RADIUS), Or(0.0), "Inner radius of a ring.";
}

tables! {
    CONTACT = "contact": ContactKeys, Optional, "Contact between objects and the finger.";
    rod_radius_mm: Number(LENGTH, NOT_NEGATIVE), Or(ROD_RADIUS_MM),
        "Radius of the rods at the key nodes of the front plate. Pressed and grasped objects touch these rods.";
    friction: Number(FRICTION, Within(-LARGEST_FRICTION, LARGEST_FRICTION)), Optional,
        "Coefficient of friction. The angle between the normal and a force with the direction `friction` is the arctangent of this coefficient, \
         positive towards the tip.";
    friction_sigma: Number(Quantity(SIGMA, ""), Within(0.0, LARGEST_FRICTION)), Or(0.0), "Standard deviation of friction.";
    friction_range: Numbers<2>(Quantity("the least and the largest coefficient of friction", ""), Within(-LARGEST_FRICTION, LARGEST_FRICTION)),
        Optional, "Replaces friction: limits of the coefficient of friction. All angles between the two corresponding angles of friction count as equally likely.";
    friction_build_up_n: Number(FORCE, NOT_NEGATIVE), Or(0.0),
        "Force scale over which the angle from the normal grows: a force F reaches the share 1 - exp(-F / friction_build_up_n) of the full angle. \
         With 0, every force has the full angle.";
    normal: Word<2>(["deformed", "undeformed"]), Or(0),
        "Normal from which the angle due to friction is measured: the normal of the deformed or of the undeformed plate.";
    normal_over_mm: Number(LENGTH, NOT_NEGATIVE), Or(0.0),
        "Length of the plate over which the deformed normal is averaged.";
    pad_mm: Number(LENGTH, NOT_NEGATIVE), Optional,
        "Thickness of the pad alone between the plate's outer face and the object; 0 for an object on the bare plate. With this key or pad_length_mm, every sensed force acts on this surface, half the plate's thickness plus pad_mm in front of its middle line, where an oblique force exerts a moment. Without both keys, forces with the direction `friction`, `object` or a standard deviation act on the surface of the plate (at a node, of its rod), and other forces on the middle line, as loads of `finray solve` do. A pad requires the estimator `nonlinear`. Neither pad_mm nor pad_length_mm may exceed the length of the front plate.";
    pad_length_mm: Number(LENGTH, NOT_NEGATIVE), Optional, "Length of the plate over which the pad distributes a force. Default: 0.";
    force_error_share: Number(Quantity("share", ""), Within(0.0, 1.0)), Or(0.0),
        "Relative standard deviation of a sensed force due to causes that no other key describes. sigma_n includes this deviation. `finray calibrate` writes this key if it estimates a modulus, or if --fit names force-error.";
}

tables! {
    TOUCHED = "contact.object": TouchedKeys, Optional,
        "A convex object of known shape that touches the front plate. Forces with the direction `object` require this table.";
    shape: Word<3>(["disc", "ellipse", "polygon"]), Required, "Type of the outline.";
    radius_mm: Number(LENGTH, Positive(LARGEST)), Of("disc"), "Radius.";
    semi_axes_mm: Numbers<2>(Quantity("lengths", "mm"), Positive(LARGEST)), Of("ellipse"), "Semi-axes along x and y before rotation.";
    corners_mm: Pairs("[x, y], corners in mm", Some(("corners", LARGEST))), Of("polygon"),
        "Corners of a convex polygon in order. One of the corners touches the plate.";
    pose_mm: Numbers<2>(Quantity("x and y", "mm"), AtMost(LARGEST)), RequiredIf("with any of the keys below"),
        "Position of the origin of the outline. Without this key, only tangency of plate and outline is assumed.";
    pose_sigma_mm: Number(Quantity(SIGMA, "mm"), Within(0.0, LARGEST)), RequiredIf("with pose_mm"),
        "Standard deviation of each coordinate of pose_mm; 0 for an exact pose.";
    rotation_deg: Number(ANGLE, Finite), Or(0.0), "Rotation of the outline, positive from x to y; not for a disc.";
    rotation_sigma_deg: Number(Quantity(SIGMA, "degrees"), Within(0.0, LARGEST)), Or(0.0), "Standard deviation of rotation_deg; not for a disc.";
    frame: Word<2>(["base", "plane"]), Or(0),
        "Frame of the outline's position and rotation. `base` is the finger frame, which moves with the base in each image. `plane` is the frame of \
         the camera's pose.";
}

tables! {
    OBJECT = "object": ObjectKeys, Optional,
        "The object that `finray press` presses onto the finger, or that `finray grasp` grasps. The motion of a pressed object requires either \
         path_mm alone, or at_mm with one of travel_mm and force_n. A grasped object requires mass_g and centre_mm.";
    shape: Word<3>(["disc", "box", "polygon"]), Required, "Type of the outline.";
    radius_mm: Number(LENGTH, Positive(LARGEST)), Of("disc"), "Radius.";
    width_mm: Number(LENGTH, Positive(LARGEST)), Of("box"), "Length of the side along x before rotation.";
    height_mm: Number(LENGTH, Positive(LARGEST)), Of("box"), "Length of the side along y before rotation.";
    points_csv: Text(), Of("polygon"),
        "Name of a CSV file with the columns x_mm,y_mm, which lists the corners in order. A relative path starts at the folder of the scene.";
    rotation_deg: Number(ANGLE, Finite), Or(0.0), "Rotation of the outline, positive from x to y.";
    friction: Number(FRICTION, Within(0.0, LARGEST_FRICTION)), Or(0.0),
        "Coefficient of Coulomb friction against fingers and support.";
    at_mm: Number(POSITION, ByOthers("on the front plate")), RequiredIf("for `finray press`, unless path_mm is given"),
        "Position at which the line of motion meets the front plate, measured from the base. The object starts where it first meets the straight line over the rods of the undeformed front plate.";
    direction_deg: Number(ANGLE, Between(-90.0, 90.0)), Or(0.0),
        "Angle of the line of motion from the undeformed inward normal, positive towards the tip.";
    travel_mm: Number(LENGTH, Positive(LARGEST)), RequiredIf("with at_mm, unless force_n is given"),
        "Travel of the object from its start.";
    force_n: Number(FORCE, Positive(LARGEST)), Optional,
        "Replaces travel_mm: the press ends when the force along the line of motion reaches this value. A guide keeps the object on this line.";
    path_mm: Pairs("[x, y], points of the finger frame in mm", Some(("two or more different points [x, y]", LARGEST))), Optional,
        "Replaces at_mm: points on the path of the object's centre; for a polygon, points on the path of the polygon's origin.";
    steps: Count("", 1, MOST_STEPS), Or(20), "Number of equal steps of a press.";
    mass_g: Number(Quantity("mass", "g"), Positive(LARGEST)), RequiredIf("for `finray grasp`"),
        "Mass of the object. The centre of mass is the centroid of the object's area.";
    centre_mm: Numbers<2>(Quantity("x and y", "mm"), AtMost(LARGEST)), RequiredIf("for `finray grasp`"),
        "Initial position of the object's centre in the frame of [grasp]; for a polygon, initial position of the polygon's origin.";
}

tables! {
    GRIPPER = "gripper": GripperKeys, Optional,
        "The linkage that moves two mirrored fingers, for `finray gripper` and `finray grasp` (Xu et al. 2021, eqs 6-9).";
    screw_pitch_mm: Number(LENGTH, Positive(LARGEST)), Required, "Travel of the nut in one revolution of the motor.";
    slider_mm: Number(Quantity("height", "mm"), AtMost(LARGEST)), Required, "Height of the nut above the fixed joints at motor angle 0.";
    link_mm: Numbers<2>(Quantity("lengths", "mm"), Positive(LARGEST)), Required,
        "Lengths of rocker and link. Rocker and link meet at the base of the finger.";
    fixed_joint_mm: Number(LENGTH, Positive(LARGEST)), Required, "Distance between the rocker's fixed joint and the screw's axis.";
    assembly: Word<2>(["outer", "inner"]), Or(0),
        "Position of the joint between rocker and link. Of the two possible positions, `outer` is farther from the screw's axis and `inner` is \
         nearer.";
}

tables! {
    GRASP = "grasp": GraspKeys, Optional,
        "Settings of `finray grasp`. Coordinates are in the gripper's frame at the start. The frame's origin lies on the screw's axis at the height \
         of the fixed joints. The x axis points to the right finger; the y axis points along the screw to the fingertips.";
    // The default step and speed of the motor are those of Xu et al. (2021), sections V-C and V-D.
    motor_deg: Numbers<2>(Quantity("motor angles", "degrees"), Finite), Required,
        "Motor angle at the start, and limit of the motor angle for closing. Both angles must be within reach of the linkage.";
    step_deg: Number(Quantity("motor angle", "degrees"), Positive(LARGEST)), Or(22.5),
        "Motor angle between two settled steps; not allowed with frames_per_s.";
    until_force_n: Number(FORCE, Positive(LARGEST)), Optional,
        "Closing stops at this sensed force: the force on a finger across the gripper, averaged over both fingers.";
    hold: Word<2>(TRUE_FALSE), Or(1), "Whether the motor keeps the sensed force at until_force_n along the path; requires until_force_n.";
    path_mm: Pairs("[x, y], points in mm relative to the start of the gripper", Some(("points", LARGEST))), Optional,
        "Corners of the path that the gripper follows from its start.";
    path_steps: Count("", 1, MOST_STEPS), Or(10), "Number of settled steps along the path.";
    open: Word<2>(TRUE_FALSE), Optional, "Whether the gripper opens at the end. Without this key, the gripper opens if path_mm is given.";
    support: Word<3>(["true", "false", "table"]), Optional,
        "Support of the object at the start. true: rails in front of and behind the fingers; the fingers pass between the rails. \"table\": a plane \
         that the fingers must not touch. false: no support; the weight acts only after the object is grasped. Without this key, the value is true, \
         or false if gravity is zero.";
    gravity_m_s2: Numbers<2>(Quantity("gravity", "m/s^2"), AtMost(LARGEST)), Or([0.0, 9.81]),
        "Acceleration of gravity, in the frame of [grasp]. The default is Earth's gravity on a gripper that points \
            down.";
    motor_deg_per_s: Number(Quantity("speed", "degrees per second"), Positive(LARGEST)), Or(30.0), "Speed of the motor; used only with frames_per_s.";
    frames_per_s: Number(Quantity("rate", "frames per second"), Positive(LARGEST)), Optional,
        "Replaces step_deg: frame rate of the camera. Each frame is one settled step.";
    delay_frames: Count("", 0, MOST_STEPS), Or(0), "Delay between an image and the force sensed from it, in frames; requires frames_per_s.";
    camera_on_gripper: Word<2>(TRUE_FALSE), Or(1),
        "For --images: true if the pose of [camera] refers to the gripper's frame (Xu et al. 2021, eq. 10), false if the pose refers to each \
         finger's frame.";
}
