//! Figures of the paper that nothing here can test.

use super::{Claim, ClaimVerdict, claim};

pub(super) fn claims() -> Vec<Claim> {
    let row = |what: &str, paper: &str, why: &str| claim(what, paper, "-", why, "", ClaimVerdict::NotTested);
    vec![
        row(
            "\"TPU has a maximum recoverable strain of 50% and Young's modulus ranging from 10 to 1000 MPa\"; this one \"of about 48 MPa\"; ABS \
             \"ranging from 1500 to 3000 Mpa\" (sec. II)",
            "as quoted",
            "data of materials, taken over; the range of TPU is held against fitted moduli above",
        ),
        row(
            "\"we suggest a rod diameter ... ranging from 1.5 to 4.25 mm\" (sec. II)",
            "3 mm chosen",
            "rods are nodes of the frame: their diameter is no part of its model",
        ),
        row(
            "Of the gripper of [74], \"the relative difference between the experimental results and the model predictions was about 25%\" (sec. II)",
            "25 %",
            "another finger",
        ),
        row(
            "\"the range of the external force at a single node is set as 0-5 N, and the range of the resultant force ... 0-10 N\"; \"20 000 groups \
             of sample data\" (sec. IV-A)",
            "as quoted",
            "the protocol of the training, followed by the recorded networks; no statement to test",
        ),
        row("Moulds with \"position errors less than 0.01 mm\" (sec. IV-B)", "0.01 mm", "needs the finger"),
        row(
            "Gripper: from the motor's angle to the finger, eqs. (6) to (10); screw pitch 4 mm, step 1.8 deg, 0.35 N m (sec. II, IV-C)",
            "as given",
            "the mechanism's dimensions are in a figure that was not at hand",
        ),
        row(
            "Camera of 1600 x 1400 at 170 mm, 30 FPS; motor steps of 22.5 deg between measurements; weights of 50 to 300 g, three times each; \
             plates of 1.5 mm, 12.75 mm from rod to rod (sec. II, IV-B, V)",
            "as given",
            "the apparatus and its protocol, taken over where they matter",
        ),
        row(
            "Force sensors with \"a measuring range of 0-10 N and an accuracy of 0.01 N\" (sec. V-C)",
            "as quoted",
            "needs the sensors",
        ),
        row(
            "\"the maximum angle between the normal direction and the sensor-axis direction is about 12.5 deg\" (sec. V-C)",
            "12.5 deg",
            "follows from the mechanism, whose dimensions were not at hand; what 12.5 deg cost is tested above",
        ),
        row(
            "\"the measured and sensed forces of the left finger are quite close to those of the right finger\" (sec. V-C; Figs. 14 and 16)",
            "no figure",
            "two equal simulated fingers are equal by construction; needs the gripper",
        ),
        row(
            "\"the force at node 18 begins to decrease and the force at 20 begins to increase, and their cross occurs when the motor angle is about \
             700 deg\" (sec. V-C, Fig. 11)",
            "500 deg, 700 deg",
            "needs the gripper's dimensions and the object",
        ),
        row(
            "Pick and place: motor at 30 deg/s, camera at 15 FPS, \"a sensed force value when the motor rotates every two degrees\"; forces symmetric \
             over 0-900 deg versus 900-0 deg (sec. V-D, Fig. 16)",
            "2 deg",
            "30 / 15 = 2; an elastic model is reversible by construction, so symmetry needs the real finger",
        ),
        row(
            "\"the grasping forces at the left node 19 are always zero since there is no physical contact\" (sec. V-D, Fig. 16)",
            "0 N",
            "needs the object; sensing where nothing touches is tested above",
        ),
    ]
}
