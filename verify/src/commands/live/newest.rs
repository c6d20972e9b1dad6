//! Hands frames from a reading thread to the evaluation: only the newest frame, or every frame.

use crate::commands::frames::{Frame, Source};
use crate::commands::{Failure, not_computed};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

/// Slot that passes one frame at a time from a reading thread to the evaluation.
pub struct Newest(Arc<Slot>);

#[derive(Default)]
struct Slot {
    state: Mutex<Waiting>,
    changed: Condvar,
}

/// The frame that waits for evaluation, and whether more frames will follow.
#[derive(Default)]
struct Waiting {
    frame: Option<Frame>,
    /// Evaluated or dropped frame whose memory is reused.
    spare: Option<Frame>,
    /// `None` while frames are read; `Some(Some(error))` if an error ended the reading; `Some(None)` after the end of the stream.
    ended: Option<Option<Failure>>,
}

impl Slot {
    // A panic of the other thread poisons the lock, but does not make the frame invalid.
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Marks the stream as ended when the reading thread ends, even by a panic, so that the evaluation does not wait for ever.
struct EndOnDrop(Arc<Slot>);

impl Drop for EndOnDrop {
    fn drop(&mut self) {
        self.0.lock().ended.get_or_insert_with(|| Some(not_computed("reading the stream stopped unexpectedly")));
        self.0.changed.notify_all();
    }
}

impl Newest {
    /// Starts to read a source. With `every_frame` no frame is dropped: reading waits for the evaluation.
    ///
    /// # Errors
    /// [`Failure`] if no thread can be started.
    pub fn of(mut source: Source, every_frame: bool) -> Result<Newest, Failure> {
        let slot = Arc::new(Slot::default());
        let writer = Arc::clone(&slot);
        let reading = thread::Builder::new().spawn(move || {
            let _end = EndOnDrop(Arc::clone(&writer));
            for number in 0.. {
                let spare = writer.lock().spare.take();
                let next = source.next(number, spare);
                let mut waiting = writer.lock();
                match next {
                    Ok(Some(mut frame)) => {
                        while every_frame && waiting.frame.is_some() {
                            waiting = writer.changed.wait(waiting).unwrap_or_else(PoisonError::into_inner);
                        }
                        if let Some(dropped) = waiting.frame.take() {
                            frame.info.dropped = dropped.info.dropped + 1;
                            waiting.spare = Some(dropped);
                        }
                        waiting.frame = Some(frame);
                        writer.changed.notify_all();
                    }
                    end => {
                        waiting.ended = Some(end.err());
                        writer.changed.notify_all();
                        return;
                    }
                }
            }
        });
        reading.map(|_| Newest(slot)).map_err(not_computed)
    }

    /// Waits for the next frame. `None` at the end of the stream.
    ///
    /// # Errors
    /// [`Failure`] if the stream cannot be read further.
    pub fn take(&self) -> Option<Result<Frame, Failure>> {
        let mut waiting = self.0.lock();
        loop {
            if let Some(frame) = waiting.frame.take() {
                self.0.changed.notify_all();
                return Some(Ok(frame));
            }
            if let Some(ended) = waiting.ended.take() {
                waiting.ended = Some(None);
                return ended.map(Err);
            }
            waiting = self.0.changed.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Returns an evaluated frame, so that its memory is reused.
    pub fn give_back(&self, frame: Frame) {
        self.0.lock().spare = Some(frame);
    }
}
