//! How much of the disk the runs of each user hold, and how much they may.
//!
//! Counted is what is there of the runs that are remembered: bundle, log and kept verdicts in the
//! state folder, what the journal tells of them, and what was recorded; and of those that are not
//! remembered any more until the last of it is gone. So nothing of a user is on the disk and not
//! counted; what all share, the cache of results and the quarantine, has bounds of its own. All
//! together leave a part of the disk to runs that go on, and as much as the journal holds, which is
//! written anew beside itself: without it no run is taken, and none begins.

use super::board::{Board, RunEntry};
use super::error::ServiceError;
use super::journal::Journal;
use super::store::{Store, free, total};
use cullet_proto::service::State;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// A file takes whole blocks of this many bytes.
const BLOCK: u64 = 4096;
/// What a run holds that does not go on is counted anew after this: a hand may have made room.
const RECOUNT: Duration = Duration::from_secs(60);

/// The bound, and what was counted lately.
#[derive(Debug, Default)]
pub(super) struct Quota {
    bound: Option<u64>,
    counted: BTreeMap<u64, (u64, Instant)>,
}

impl Quota {
    /// At most so many bytes for each user; `None`: no bound.
    pub(super) fn new(bound: Option<u64>) -> Self {
        Self { bound, counted: BTreeMap::new() }
    }

    /// What a run holds has changed.
    pub(super) fn changed(&mut self, run: u64) {
        self.counted.remove(&run);
    }

    /// Whether a user may hold so many bytes more.
    ///
    /// # Errors
    /// [`ServiceError::Quota`].
    pub(super) fn room(
        &mut self,
        (user, more): (&str, u64),
        board: &Board,
        (store, out, journal): (&Store, &Path, &Journal),
    ) -> Result<(), ServiceError> {
        let Some(bound) = self.bound else {
            return Ok(());
        };
        let all = board.entries().chain(board.leaving());
        let own = all.filter(|entry| entry.order.user == user);
        let bytes = |entry: &RunEntry| self.of(entry, store, out) + journal.of(entry.run);
        let used: u64 = own.map(bytes).sum();
        match used.saturating_add(more) > bound {
            true => Err(ServiceError::Quota { user: user.to_owned(), used, more, bound }),
            false => Ok(()),
        }
    }

    fn of(&mut self, entry: &RunEntry, store: &Store, out: &Path) -> u64 {
        let lately = |(_, at): &&(u64, Instant)| at.elapsed() < RECOUNT;
        if entry.state != State::Running
            && let Some((bytes, _)) = self.counted.get(&entry.run).filter(lately)
        {
            return *bytes;
        }
        let recorded = entry.folder.as_ref().map_or(0, |folder| held(&out.join(folder)));
        let bytes = held(&store.run(entry.run)) + recorded;
        self.counted.insert(entry.run, (bytes, Instant::now()));
        bytes
    }
}

/// Least and most of a disk that is kept for runs that go on, if nobody says how much.
const RESERVE: std::ops::RangeInclusive<u64> = 32 << 20..=2 << 30;

/// Whether the disks that these folders are on have room for so many bytes more, beside what is
/// kept for runs that go on (what was said, or a twentieth of a disk) and for a journal of so many
/// bytes, which is written anew beside itself.
///
/// # Errors
/// [`ServiceError::Full`].
pub(super) fn disks(
    more: u64,
    (said, journal): (Option<u64>, u64),
    folders: [&Path; 2],
) -> Result<(), ServiceError> {
    for folder in folders {
        // One that is not there yet will be on the disk of the first above it that is.
        let there = folder.ancestors().find(|folder| folder.exists()).unwrap_or(Path::new("."));
        let (Some(free), Some(total)) = (free(there), total(there)) else { continue };
        let usual = (total / 20).min(*RESERVE.end());
        let reserve = said.unwrap_or(usual).max(*RESERVE.start()).saturating_add(journal);
        if free < more.saturating_add(reserve) {
            return Err(ServiceError::Full { folder: folder.to_owned(), free, more, reserve });
        }
    }
    Ok(())
}

/// Bytes of the disk under a folder. What cannot be read holds nothing.
fn held(folder: &Path) -> u64 {
    let files = fs::read_dir(folder).into_iter().flatten().flatten();
    let size = |file: fs::DirEntry| match file.metadata() {
        Ok(about) if about.is_dir() => BLOCK + held(&file.path()),
        Ok(about) => about.len().next_multiple_of(BLOCK),
        Err(_) => 0,
    };
    files.map(size).sum()
}

#[cfg(test)]
mod tests {
    use super::{BLOCK, Quota, RESERVE, disks, held};
    use crate::attempt::discard;
    use crate::board::{Board, BoardEvent, Submission};
    use crate::journal::{Journal, MAX_BYTES, size};
    use crate::{ServiceError, Store};
    use std::fs;

    #[test]
    fn a_forgotten_run_takes_its_own_files_with_it_and_no_others() {
        let place = tempfile::tempdir().expect("a folder");
        let [plain, shared] = ["pot-1", "pot-2"].map(|name| place.path().join(name));
        for folder in [&plain, &shared] {
            fs::create_dir_all(folder).expect("a folder");
            for file in ["run.mcap", "run.mcap.partial", "timeline.svg", ".cullet-x1y2z3"] {
                fs::write(folder.join(file), b"x").expect("a file");
            }
        }
        fs::write(shared.join("thesis.tex"), b"x").expect("a file");
        for folder in [&plain, &shared, &place.path().join("never")] {
            discard(folder).expect("it goes");
        }
        assert!(!plain.exists() && !place.path().join("never").exists());
        let left: Vec<_> = fs::read_dir(&shared).expect("a folder").flatten().collect();
        assert_eq!(left.iter().map(fs::DirEntry::file_name).collect::<Vec<_>>(), ["thesis.tex"]);
    }

    #[test]
    fn a_disk_that_is_nearly_full_takes_no_run() {
        let place = tempfile::tempdir().expect("a folder");
        let (here, never) = (place.path(), place.path().join("not/there"));
        assert!(disks(1, (Some(0), 0), [here, &never]).is_ok());
        let said = disks(u64::MAX, (None, 0), [here, here]).expect_err("so much is nowhere");
        let said = said.to_string();
        assert!(said.starts_with(&format!("{}: ", here.display())), "{said}");
        assert!(said.contains("this run needs 18446744073709551615, and "), "{said}");
        // The other folder counts too, and what is kept is kept whoever asks for how little.
        let free = super::free(here).expect("it is told");
        let said = disks(0, (Some(u64::MAX), 0), [here, &never]).expect_err("all of it is kept");
        assert!(said.to_string().contains(" bytes of the disk are free, and "), "{said}");
        let least = free.saturating_sub(RESERVE.start() / 2);
        assert!(disks(least, (Some(0), 0), [here, here]).is_err());
        // So does what a journal takes that is written anew.
        let told = |journal| disks(0, (Some(0), journal), [here, here]);
        assert!(told(0).is_ok() && told(free).is_err());
    }

    #[test]
    fn what_counts_is_all_that_a_users_runs_hold_and_nobody_elses() {
        let store = Store::open(None).expect("a folder of its own");
        let out = store.folder().join("recordings");
        let (mut journal, mut board, _) =
            Journal::open(&store.folder().join("journal"), MAX_BYTES).expect("a journal");
        for (run, user) in [(1, "ann"), (2, "bob"), (3, "ann")] {
            let order =
                Submission { user: user.into(), ticket: run.to_string(), ..Submission::default() };
            let folder = format!("pot-{run}");
            fs::create_dir_all(out.join(&folder)).expect("a folder");
            fs::write(out.join(&folder).join("run.mcap"), vec![0; 5000]).expect("a recording");
            store.keep_bundle(run, &[0; 100]).expect("a bundle");
            for event in
                [BoardEvent::Submitted { run, order }, BoardEvent::Started { run, folder, at: 1 }]
            {
                board.apply(&event).expect("it fits");
            }
        }
        assert_eq!(held(&out.join("pot-1")), 2 * BLOCK);
        let place = (&store, out.as_path(), &journal);
        let mut quota = Quota::new(Some(8 * BLOCK));
        assert!(quota.room(("ann", 2 * BLOCK), &board, place).is_ok());
        let said = quota.room(("ann", 2 * BLOCK + 1), &board, place).expect_err("too much");
        let want = format!("ann hold {} bytes", 6 * BLOCK);
        assert!(said.to_string().contains(&want), "{said}");
        assert!(quota.room(("bob", 5 * BLOCK), &board, place).is_ok());
        assert!(quota.room(("bob", 5 * BLOCK + 1), &board, place).is_err());
        // What goes on is looked at each time, what does not after a while or when it has changed.
        let kept = |bytes: usize| fs::write(store.run(1).join("log"), vec![0; bytes]);
        kept(1).expect("a log");
        assert!(quota.room(("ann", BLOCK + 1), &board, place).is_err());
        board.apply(&BoardEvent::Returned { at: 2 }).expect("it fits");
        kept(BLOCK as usize + 1).expect("a log");
        assert!(quota.room(("ann", BLOCK), &board, place).is_ok());
        quota.changed(1);
        assert!(quota.room(("ann", BLOCK), &board, place).is_err());
        let mut full = Quota::new(Some(BLOCK));
        let said = full.room(("ann", 0), &board, place).expect_err("too much").to_string();
        let want = format!("of the disk here, more than the {BLOCK} that a user may hold");
        assert!(said.ends_with(&want), "{said}");
        // What is forgotten counts until the last of it is gone.
        let used = |board: &Board| {
            let said = Quota::new(Some(0)).room(("ann", 1), board, place).expect_err("too much");
            said.to_string()
        };
        let before = used(&board);
        let (end, at) = (Default::default(), 3);
        for event in [BoardEvent::Cancelled { run: 1, end, at }, BoardEvent::Forgotten { run: 1 }] {
            board.apply(&event).expect("it fits");
        }
        assert_eq!(used(&board), before);
        board.apply(&BoardEvent::Removed { run: 1 }).expect("it fits");
        assert_ne!(used(&board), before);
        assert!(Quota::new(None).room(("ann", u64::MAX), &board, place).is_ok());
        // What the journal tells of a run counts, too.
        let told = [BoardEvent::Paused { run: 3 }];
        let used = |journal: &Journal| {
            let place = (&store, out.as_path(), journal);
            match Quota::new(Some(0)).room(("ann", 1), &board, place) {
                Err(ServiceError::Quota { used, .. }) => used,
                other => panic!("{other:?}"),
            }
        };
        let before = used(&journal);
        journal.append(&told).expect("it is written");
        assert_eq!(used(&journal), before + size(&told));
    }
}
