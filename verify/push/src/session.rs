//! Questions and answers as JSON.

use crate::{Push, PushedFinger};
use serde::Deserialize;
use serde_json::{Value, json};

/// A question of a page.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
enum Asked {
    /// Loads the finger of a scene. The answer is the finger's [`Drawing`](crate::Drawing).
    Finger {
        /// Text of the scene.
        scene: String,
        /// Text of a scene with a second finger, which a push can use as the true finger.
        other: Option<String>,
    },
    /// Pushes the finger. The answer is [`Pushed`](crate::Pushed).
    Push(Push),
}

/// Answers the questions of a page about the finger that the page loaded last.
#[derive(Debug, Default)]
pub struct Session {
    finger: Option<PushedFinger>,
}

impl Session {
    /// Answers a question in JSON. The question `{"finger": {"scene": TEXT, "other": TEXT}}` loads the finger of a scene and returns a
    /// [`Drawing`](crate::Drawing). The question `{"push": {...}}` has the fields of [`Push`] and returns [`Pushed`](crate::Pushed). An invalid
    /// question returns `{"error": TEXT}` and leaves the loaded finger unchanged.
    pub fn answer(&mut self, question: &str) -> String {
        self.answered(question).unwrap_or_else(|error| json!({ "error": error })).to_string()
    }

    fn answered(&mut self, question: &str) -> Result<Value, String> {
        let value = |answer: serde_json::Result<Value>| answer.map_err(|error| error.to_string());
        match serde_json::from_str(question).map_err(|error| error.to_string())? {
            Asked::Finger { scene, other } => {
                let finger = PushedFinger::new(&scene, other.as_deref()).map_err(|error| error.to_string())?;
                let drawing = finger.drawing();
                self.finger = Some(finger);
                value(serde_json::to_value(drawing))
            }
            Asked::Push(push) => {
                let finger = self.finger.as_ref().ok_or("expected a finger first, found a push")?;
                value(serde_json::to_value(finger.push(&push)))
            }
        }
    }
}
