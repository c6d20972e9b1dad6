//! Library tests of `verify`, a module for each of its rooms: the lattice and the shapes that MuJoCo found, the fingers that sensing is
//! tested on (`truths`), `estimators`, `sampling`, images of the finger and what is found in them (`imaging`), the reference `problems`, the `experiments`, their `statistics` and the paper's `claims`. `rooms` checks that no
//! rooms use each other in a circle, and `stand_ins` has the estimators that stand in for real ones. Tests that run the `finray` command
//! stand in `verify/tests`.

mod check;
mod claims;
mod estimators {
    mod all;
    mod networks;
    mod stated_intervals;
}
mod experiments {
    mod assumed;
    mod causes;
    mod contact_scenes;
    mod coverage;
    mod directions;
    mod displacement_noise;
    mod explanations;
    mod hard_cases;
    mod networks;
    mod noise;
    pub mod speed_error;
    mod table_two;
    mod twin;
}
mod figures {
    mod bars;
    mod chart;
    mod film;
    mod layout;
    mod map;
}
mod grasp {
    mod contact;
    mod energy;
    mod loops;
    mod modules;
    mod observations;
    mod obstacles;
    mod sensed;
    mod world;
}
mod imaging {
    mod chain;
    mod kit;
    mod lens;
    mod locate;
    mod rims;
}
mod lattice {
    mod accuracy;
    mod energy;
    mod settling;
}
mod mujoco;
mod one_sensor;
mod problems {
    mod closed_forms;
    mod lattice;
    mod mujoco;
    mod opensees;
}
mod report {
    mod claims;
    mod dataset;
    mod explore;
    mod format;
    mod lattice;
    mod maps {
        mod drawings;
    }
    mod measured;
    mod page;
    mod speed_error;
    mod table_two {
        mod words;
    }
    mod trainings;
    mod twin {
        mod words;
    }
    mod words;
}
mod rooms;
mod sampling {
    mod bound;
    mod map;
    pub mod scatter;
    mod shared_start;
}
mod stand_ins;
mod statistics;
mod truths {
    mod all;
    mod lattice;
    mod mujoco;
}
