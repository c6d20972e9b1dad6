//! Long computations that Ctrl-C ends.

use pyo3::prelude::*;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use crate::error::failed;

/// Time between two looks for a signal. Shorter than a person notices, and far longer than a look takes.
const LOOK: Duration = Duration::from_millis(50);

/// Runs a computation on another thread, so that Python handles its signals meanwhile. A signal whose handler raises, such as Ctrl-C, ends the call with this
/// exception. The computation gets a flag that is then set; a computation that does not read the flag goes on in the background, and its result is dropped.
pub fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    compute: impl FnOnce(&Arc<AtomicBool>) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    let stop = Arc::new(AtomicBool::new(false));
    let (out, mut found) = channel();
    let flag = Arc::clone(&stop);
    let worker = thread::Builder::new().spawn(move || {
        // Nobody waits for the result after an exception.
        let _ = out.send(compute(&flag));
    });
    let worker = worker.map_err(failed)?;
    loop {
        let found = &mut found;
        match py.detach(move || found.recv_timeout(LOOK)) {
            Ok(result) => return result,
            Err(RecvTimeoutError::Timeout) => {
                py.check_signals().inspect_err(|_| stop.store(true, Ordering::Relaxed))?;
            }
            Err(RecvTimeoutError::Disconnected) => match worker.join() {
                Ok(()) => return Err(failed("the computation ended without a result")),
                Err(panic) => resume_unwind(panic),
            },
        }
    }
}
