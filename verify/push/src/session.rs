//! Questions and answers as JSON.

use crate::{Push, PushedFinger};
use serde::Deserialize;
use serde_json::{Value, json};

/// A question of a page.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
enum Asked {
    /// Takes the finger of a scene. The answer is its [`Drawing`](crate::Drawing).
    Finger {
        /// Text of the scene.
        scene: String,
        /// Text of the scene of another true finger.
        other: Option<String>,
    },
    /// Pushes the finger. The answer is [`Pushed`](crate::Pushed).
    Push(Push),
}

/// A page's questions about one finger after another.
#[derive(Debug, Default)]
pub struct Session {
    finger: Option<PushedFinger>,
}

impl Session {
    /// Answers a question in JSON: `{"finger": {"scene": TEXT, "other": TEXT}}` takes the finger of a scene and gives a [`Drawing`](crate::Drawing);
    /// `{"push": {...}}`, with the fields of [`Push`], gives [`Pushed`](crate::Pushed). A question that has no answer gives `{"error": TEXT}`, and the
    /// finger stays as it was.
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
