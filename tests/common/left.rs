//! Whether a test leaves processes behind: those that it begins, and theirs, have its mark in their
//! environment.

use std::cell::RefCell;
use std::fs;
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

const NAME: &str = "CULLET_TEST_MARK";
/// Workers end when their parent does, and their jobs when they do.
const PATIENCE: Duration = Duration::from_secs(20);

thread_local! {
    static MARK: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Made first in a test, it goes last, and then nobody may be left whom the test's thread began.
pub(crate) struct NobodyLeft(String);

impl NobodyLeft {
    pub(crate) fn watch() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let mark = format!("{}-{number}", std::process::id());
        MARK.set(Some(mark.clone()));
        Self(mark)
    }

    /// Who has the mark.
    fn left(&self) -> Vec<u32> {
        let entry = format!("{NAME}={}", self.0).into_bytes();
        let all = fs::read_dir("/proc").into_iter().flatten().flatten();
        let ids = all.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
        let marked = |id: &u32| {
            let bytes = fs::read(format!("/proc/{id}/environ")).unwrap_or_default();
            bytes.split(|byte| *byte == 0).any(|words| words == entry)
        };
        ids.filter(marked).collect()
    }
}

impl Drop for NobodyLeft {
    fn drop(&mut self) {
        MARK.set(None);
        if !std::thread::panicking() {
            super::until("nobody is left behind", PATIENCE, || self.left().is_empty());
        }
    }
}

pub(super) fn mark(command: &mut Command) {
    MARK.with_borrow(|mark| mark.as_ref().map(|mark| command.env(NAME, mark)));
}
