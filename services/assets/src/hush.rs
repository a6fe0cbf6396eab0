//! Panics of others' code that are errors of a file, kept off standard error.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    static HUSHED: Cell<bool> = const { Cell::new(false) };
}

/// Calls, and catches a panic without a word of it. What panics on other threads meanwhile, or here
/// afterwards, is told as ever.
pub(super) fn hushed<T>(call: impl FnOnce() -> T) -> std::thread::Result<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let told = take_hook();
        set_hook(Box::new(move |panic| {
            // A thread that is ending has no flag any more, and nothing to hush.
            if !HUSHED.try_with(Cell::get).unwrap_or(false) {
                told(panic);
            }
        }));
    });
    let before = HUSHED.replace(true);
    let done = catch_unwind(AssertUnwindSafe(call));
    HUSHED.set(before);
    done
}
