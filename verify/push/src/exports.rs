//! Functions that a page calls. The page writes a question into the memory that [`question`] returns, and calls [`answer`], which returns the length of the
//! answer. The page then reads the answer at the address that [`text`] returns.
//!
//! An exported function needs the attribute `no_mangle` to keep its name. The attribute counts as unsafe, because a linker would confuse two
//! functions of the same name. No other function has one of the names in this file, and the functions contain no unsafe code.
#![allow(unsafe_code)]

use crate::Session;
use std::cell::RefCell;

/// The session of the page, its question and its answer.
#[derive(Default)]
struct Shared {
    session: Session,
    question: Vec<u8>,
    answer: String,
}

thread_local! {
    static SHARED: RefCell<Shared> = RefCell::default();
}

/// Memory for a question of `length` bytes in UTF-8.
#[unsafe(no_mangle)]
pub extern "C" fn question(length: usize) -> *mut u8 {
    SHARED.with_borrow_mut(|shared| {
        shared.question = vec![0; length];
        shared.question.as_mut_ptr()
    })
}

/// Answers the question and returns the length of the answer in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> usize {
    SHARED.with_borrow_mut(|shared| {
        shared.answer = shared.session.answer(&String::from_utf8_lossy(&shared.question));
        shared.answer.len()
    })
}

/// Address of the answer's text.
#[unsafe(no_mangle)]
pub extern "C" fn text() -> *const u8 {
    SHARED.with_borrow(|shared| shared.answer.as_ptr())
}
