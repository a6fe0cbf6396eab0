//! How a run goes: by a user's word, or because too many are remembered.
//!
//! First the journal says so, and from then on no answer has the run; then its files go; then
//! the journal says that they are gone. A coordinator that is killed in between goes on with it at
//! its next start, before any run begins, and what is still there counts towards the quota. So no
//! run is there in half, and nothing is on the disk that nobody knows of.

use super::attempt::discard;
use super::board::{Board, BoardEvent, RunEntry};
use super::error::ServiceError;
use super::journal::Journal;
use super::service::Service;
use super::store::Store;
use cullet_files::set_aside;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// Before the files of a run that could not be removed are tried again.
const AGAIN: Duration = Duration::from_secs(60);

impl Service<'_> {
    /// Removes what runs left that are not remembered any more.
    pub(super) fn prune(&mut self) {
        let tried = |run: &u64| self.pruning.stuck.get(run).is_some_and(|at| at.elapsed() < AGAIN);
        let leaving = self.board.leaving().filter(|entry| !tried(&entry.run));
        for entry in leaving.cloned().collect::<Vec<_>>() {
            let run = entry.run;
            self.runs.statuses.remove(&run);
            self.clients.awaited.remove(&run);
            self.storage.quota.changed(run);
            // A folder that is gone may be another run's by now.
            let free =
                |name: &&String| self.board.entries().all(|e| e.folder.as_ref() != Some(name));
            let recording =
                entry.folder.as_ref().filter(free).map(|name| self.storage.out.join(name));
            self.mark_given(run);
            let kept = self.storage.store.forget(run);
            let recorded = recording.as_deref().map_or(Ok(()), discard);
            match kept.and(recorded) {
                Ok(()) => {
                    self.pruning.stuck.remove(&run);
                    self.admit(BoardEvent::Removed { run });
                }
                Err(error) => {
                    tracing::warn!(run, "its files do not go, and are tried again: {error}");
                    self.pruning.stuck.insert(run, Instant::now());
                }
            }
        }
    }

    /// The folder of a run is what says, beside the journal, that its number was given.
    fn mark_given(&mut self, run: u64) {
        if run <= self.pruning.given {
            return;
        }
        let last = self.board.last();
        match self.storage.store.give(last) {
            Ok(()) => self.pruning.given = last,
            // Where there is no room, this makes some.
            Err(error) => tracing::warn!("{error}"),
        }
    }
}

/// Up to which number runs have been, as the folder says and, from now on, the board: a journal
/// that a hand has cut tells of fewer.
pub(super) fn numbered(
    store: &Store,
    journal: &mut Journal,
    board: &mut Board,
) -> Result<u64, ServiceError> {
    let last = store.given(board.last())?;
    if last > board.last() {
        let numbered = BoardEvent::Numbered { last };
        journal.append(std::slice::from_ref(&numbered))?;
        // It fits any board.
        let _fits = board.apply(&numbered);
    }
    // The folders that say so may go.
    store.give(last)?;
    Ok(last)
}

/// Sets aside what crashes left that no run has: what was kept of a run that was never accepted,
/// and, in a folder for recordings of this coordinator's own, the empty folders of attempts that
/// never began. What was kept of a run that was accepted is there, too, where the journal has lost
/// it.
pub(super) fn sweep(store: &Store, board: &Board, own: Option<&Path>) {
    let all = || board.entries().chain(board.leaving());
    let known: BTreeSet<u64> = all().map(|entry| entry.run).collect();
    store.sweep(&|run| known.contains(&run));
    let named: BTreeSet<&str> =
        all().filter_map(|entry: &RunEntry| entry.folder.as_deref()).collect();
    for folder in own.and_then(|own| fs::read_dir(own).ok()).into_iter().flatten().flatten() {
        let empty = || fs::read_dir(folder.path()).is_ok_and(|mut files| files.next().is_none());
        if folder.file_name().to_str().is_some_and(|name| !named.contains(name)) && empty() {
            set_aside::tell(store.folder(), &folder.path(), "no run is recorded there");
        }
    }
}
