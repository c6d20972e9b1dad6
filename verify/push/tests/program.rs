//! The program that is embedded in pages gives the same answers as the library, if it was built from the present code. An earlier program must still
//! answer in the form that pages read.

use finray_fixtures::{PAPER_SCENE, TWIN_SCENE};
use finray_push::{PROGRAM, Session, program_is_current};
use finray_tests::{case_count, random_stream};
use rand::RngExt;
use serde_json::{Value, json};
use wasmi::{Engine, Instance, Linker, Module, Store, TypedFunc};

/// Tolerance for a number, relative to the largest number of its answer. Program and library round differently, because they order sums differently.
const ROUNDING: f64 = 1e-12;
/// Same as [`ROUNDING`], for results of an iteration, which ends within its tolerance and not at an exact number.
const ITERATION: f64 = 1e-9;

/// The program, run by an interpreter.
struct Program {
    store: Store<()>,
    instance: Instance,
}

impl Program {
    fn new() -> Program {
        let engine = Engine::default();
        let module = Module::new(&engine, PROGRAM).expect("a program");
        let mut store = Store::new(&engine, ());
        let instance = Linker::new(&engine).instantiate_and_start(&mut store, &module).expect("no imports");
        Program { store, instance }
    }

    fn function<Given: wasmi::WasmParams, Got: wasmi::WasmResults>(&self, name: &str) -> TypedFunc<Given, Got> {
        self.instance.get_typed_func(&self.store, name).expect("a function")
    }

    fn answer(&mut self, question: &str) -> String {
        let memory = self.instance.get_memory(&self.store, "memory").expect("memory");
        let place = self.function::<i32, i32>("question").call(&mut self.store, question.len() as i32).expect("memory");
        memory.write(&mut self.store, place as usize, question.as_bytes()).expect("room");
        let length = self.function::<(), i32>("answer").call(&mut self.store, ()).expect("an answer");
        let place = self.function::<(), i32>("text").call(&mut self.store, ()).expect("a place");
        let mut text = vec![0; length as usize];
        memory.read(&self.store, place as usize, &mut text).expect("a text");
        String::from_utf8(text).expect("UTF-8")
    }
}

/// Largest difference between the numbers of two answers; `None` if anything else differs. Raises `largest` to the largest magnitude of a number.
fn apart(one: &Value, other: &Value, largest: &mut f64) -> Option<f64> {
    match (one, other) {
        (Value::Number(one), Value::Number(other)) => {
            let [one, other] = [one.as_f64()?, other.as_f64()?];
            *largest = largest.max(one.abs());
            Some((one - other).abs())
        }
        (Value::Array(one), Value::Array(other)) if one.len() == other.len() => {
            one.iter().zip(other).try_fold(0.0, |far, (one, other)| Some(f64::max(far, apart(one, other, largest)?)))
        }
        (Value::Object(one), Value::Object(other)) if one.len() == other.len() => {
            one.iter().try_fold(0.0, |far, (key, one)| Some(f64::max(far, apart(one, other.get(key)?, largest)?)))
        }
        _ => (one == other).then_some(0.0),
    }
}

#[track_caller]
fn assert_near(question: &Value, one: &Value, other: &Value, tolerance: f64) {
    let mut largest = 0.0;
    let far = apart(one, other, &mut largest);
    assert!(far.is_some_and(|far| far <= tolerance * largest), "{question}: {far:?} of {largest}: {one} and {other}");
}

#[test]
fn the_program_of_pages_answers_as_the_library_does() {
    let (mut program, mut library) = (Program::new(), Session::default());
    let mut chance = random_stream(46, 0);
    let finger = json!({ "finger": { "scene": PAPER_SCENE, "other": TWIN_SCENE } });
    let mut ask = |question: &Value| {
        let both = [program.answer(&question.to_string()), library.answer(&question.to_string())];
        both.map(|text| serde_json::from_str::<Value>(&text).expect("JSON"))
    };
    let [one, other] = ask(&finger);
    let known = json!({ "push": { "s_mm": 70.0, "angle_deg": 0.0, "force_n": 1.0, "contact": "known", "estimator": "nonlinear", "noise_mm": 0.067,
        "image": 1 } });
    if !program_is_current() {
        for [one, other] in [[one, other], ask(&known)] {
            assert_near(&known, &one, &other, f64::INFINITY);
        }
        return;
    }
    assert_near(&finger, &one, &other, ROUNDING);
    let estimators = ["nonlinear", "least-squares", "ridge"];
    for case in 0..case_count(24, 200) {
        let contact = [json!("known"), json!({ "off": { "by_mm": 1.5, "by_deg": 12.5 } }), json!("sought")];
        let question = json!({ "push": {
            "s_mm": chance.random_range(3.0..150.0),
            "angle_deg": chance.random_range(-80.0..80.0),
            "force_n": chance.random_range(0.05..4.0),
            "is_other": case % 4 == 3,
            // A search for the contact is slow in an interpreter, so only a few cases include a search.
            "contact": contact[if case % 12 == 5 { 2 } else { case % 2 }],
            "estimator": estimators[case % 3],
            "noise_mm": 0.067,
            "image": case,
        }});
        let [one, other] = ask(&question);
        let [bent, known] = [&one, &other].map(|answer| answer.get("bent"));
        let (Some(bent), Some(known)) = (bent, known) else {
            assert_eq!(one, other, "{question}");
            continue;
        };
        for shape in ["lines", "at", "displacements", "seen"] {
            assert_near(&question, &bent[shape], &known[shape], ROUNDING);
        }
        match [bent, known].map(|answer| answer["sensed"].get("force")) {
            [Some(force), Some(expected)] => {
                for number in ["force_n", "interval_n", "s_mm", "angle_deg"] {
                    assert_near(&question, &force[number], &expected[number], ITERATION);
                }
                let warned = [force, expected].map(|force| force["warnings"].as_array().map(Vec::len));
                assert_eq!(warned[0], warned[1], "{question}");
            }
            _ => assert_eq!(bent["sensed"], known["sensed"], "{question}"),
        }
    }
}
