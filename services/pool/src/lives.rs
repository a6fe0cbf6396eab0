//! Which lives of workers are there, by their signs of life; how often one went and came back; and
//! which share a name. No I/O, and time is an argument.
//!
//! A name is a worker's own, but nobody keeps two from having the same where no certificate does.
//! One that is started again is called as the one before was, whose sign may be seen a little
//! longer, as is one that finishes its last job. So two are reported only when both have been there
//! for longer than a link that died is held, and neither is on its way out.

use super::session_names::MAX_SESSIONS;
use cullet_proto::{SessionId, WorkerId};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::{Duration, Instant};

/// Lives remembered whose sign is gone.
const MAX_AWAY: usize = 4_096;
/// Signs of life of one name that are taken in; further ones wait until others go.
const MAX_OF_NAME: usize = 16;
/// Signs of life that wait; beyond it they are not seen at all.
const MAX_WAITING: usize = 1_024;

/// The sessions of connected workers, and the names that several of them have.
#[derive(Debug, Default)]
pub(super) struct LiveWorkers {
    pub(super) up: BTreeSet<SessionId>,
    /// Since when each is there, by name.
    named: BTreeMap<WorkerId, BTreeMap<SessionId, Instant>>,
    /// Signs for which there is no room, the oldest first.
    waiting: VecDeque<(WorkerId, SessionId, Instant)>,
    /// Names that several have.
    several: BTreeSet<WorkerId>,
    /// Those that were reported, by name.
    reported: BTreeMap<WorkerId, BTreeSet<SessionId>>,
    /// Those that get no further job.
    leaving: BTreeSet<SessionId>,
    away: BTreeSet<SessionId>,
    /// How long two may have one name.
    patience: Duration,
    /// Signs that went: a worker left, or its link did.
    pub(super) lost: u64,
    /// Signs that came back: a link flapped.
    pub(super) back: u64,
}

impl LiveWorkers {
    /// `patience`: how long a link that died is held.
    pub(super) fn new(patience: Duration) -> Self {
        Self { patience, ..Self::default() }
    }

    /// A sign of life came or went.
    pub(super) fn sign(&mut self, name: WorkerId, life: SessionId, up: bool, now: Instant) {
        let same = |(of, waits, _): &(WorkerId, SessionId, Instant)| (of, waits) == (&name, &life);
        if up && self.has_room(&name) {
            self.came(name, life, now);
        } else if up {
            let known = self.up.contains(&life) || self.waiting.iter().any(same);
            if !known && self.waiting.len() < MAX_WAITING {
                self.waiting.push_back((name, life, now));
            }
        } else if self.named.get(&name).is_some_and(|own| own.contains_key(&life)) {
            self.went(&name, life);
            let free = |(of, ..): &(WorkerId, SessionId, Instant)| self.has_room(of);
            let next = self.waiting.iter().position(free);
            if let Some((of, life, since)) = next.and_then(|at| self.waiting.remove(at)) {
                self.came(of, life, since);
            }
        } else {
            self.waiting.retain(|waits| !same(waits));
        }
    }

    /// Whether one more sign of a name is taken in.
    fn has_room(&self, name: &WorkerId) -> bool {
        let own = self.named.get(name).map_or(0, BTreeMap::len);
        own < MAX_OF_NAME && self.up.len() < MAX_SESSIONS
    }

    fn came(&mut self, name: WorkerId, life: SessionId, now: Instant) {
        if !self.up.insert(life) {
            return;
        }
        self.back += u64::from(self.away.remove(&life));
        let all = self.named.entry(name.clone()).or_default();
        all.insert(life, now);
        if all.len() > 1 {
            self.several.insert(name);
        }
    }

    fn went(&mut self, name: &WorkerId, life: SessionId) {
        self.up.remove(&life);
        self.lost += 1;
        self.leaving.remove(&life);
        self.away.insert(life);
        if self.away.len() > MAX_AWAY {
            self.away.pop_first();
        }
        let Some(all) = self.named.get_mut(name) else { return };
        all.remove(&life);
        if all.len() < 2 {
            self.several.remove(name);
        }
        if all.is_empty() {
            self.named.remove(name);
        }
    }

    /// It gets no further job.
    pub(super) fn leaves(&mut self, life: SessionId) {
        if self.up.contains(&life) {
            self.leaving.insert(life);
        }
    }

    /// Whether it was reported as one of several.
    pub(super) fn has_duplicate_name(&self, life: SessionId) -> bool {
        self.reported.values().any(|all| all.contains(&life))
    }

    /// How many were.
    pub(super) fn duplicate_names(&self) -> u64 {
        self.reported.values().map(|all| all.len() as u64).sum()
    }

    /// Time has passed: names that others share now than before, with all who have each; where one
    /// is left, nobody.
    pub(super) fn tick(&mut self, now: Instant) -> Vec<(WorkerId, BTreeSet<SessionId>)> {
        let mut news = Vec::new();
        let names = self.several.iter().chain(self.reported.keys());
        for name in names.cloned().collect::<BTreeSet<_>>() {
            let all = self.named.get(&name).into_iter().flatten();
            let stays = |(life, since): &(&SessionId, &Instant)| {
                !self.leaving.contains(life) && now.duration_since(**since) >= self.patience
            };
            let mut alike: BTreeSet<_> = all.filter(stays).map(|(life, _)| *life).collect();
            if alike.len() < 2 {
                alike.clear();
            }
            if self.reported.get(&name) == Some(&alike)
                || alike.is_empty() && !self.reported.contains_key(&name)
            {
                continue;
            }
            match alike.is_empty() {
                true => self.reported.remove(&name),
                false => self.reported.insert(name.clone(), alike.clone()),
            };
            news.push((name, alike));
        }
        news
    }
}

#[cfg(test)]
mod tests {
    use super::LiveWorkers;
    use cullet_proto::{SessionId, WorkerId};
    use std::time::{Duration, Instant};

    const PATIENCE: Duration = Duration::from_secs(8);

    /// What is reported at each step: a sign of a life that comes or goes, or nothing, after so
    /// many seconds.
    fn told(steps: &[(u64, Option<(u64, bool)>)]) -> (Vec<Vec<u64>>, LiveWorkers) {
        let (mut lives, begun) = (LiveWorkers::new(PATIENCE), Instant::now());
        let mut told = Vec::new();
        for (at, sign) in steps {
            let now = begun + Duration::from_secs(*at);
            if let Some((life, up)) = *sign {
                lives.sign(WorkerId::new("far").expect("a name"), SessionId(life), up, now);
            }
            let news = lives.tick(now).into_iter();
            told.extend(
                news.map(|(_, all)| all.into_iter().map(|life| life.0).collect::<Vec<_>>()),
            );
        }
        (told, lives)
    }

    #[test]
    fn two_of_a_name_are_told_once_and_again_when_that_changes() {
        let steps = [(0, Some((1, true))), (1, Some((2, true))), (8, None)];
        assert_eq!(told(&steps).0, Vec::<Vec<u64>>::new(), "the second is there for 7 s");
        let more = [&steps[..], &[(9, None), (10, None), (11, None)]].concat();
        let (said, lives) = told(&more);
        assert_eq!(said, [[1, 2]]);
        assert!(lives.has_duplicate_name(SessionId(1)) && lives.duplicate_names() == 2);
        let third = [&more[..], &[(12, Some((3, true))), (20, None)]].concat();
        assert_eq!(told(&third).0, [vec![1, 2], vec![1, 2, 3]]);
        let end = [&more[..], &[(12, Some((1, false))), (30, None)]].concat();
        let (said, lives) = told(&end);
        assert_eq!(said, [vec![1, 2], vec![]]);
        assert!(!lives.has_duplicate_name(SessionId(2)) && lives.duplicate_names() == 0);
    }

    #[test]
    fn one_that_is_started_again_is_nobody_elses_twin() {
        // The old one's link is given up after 5 s; the old one takes an hour to finish its job.
        let (said, lives) =
            told(&[(0, Some((1, true))), (9, Some((2, true))), (14, Some((1, false))), (99, None)]);
        assert!(said.is_empty(), "{said:?}");
        assert_eq!((lives.lost, lives.back), (1, 0));
        let (mut lives, begun) = (LiveWorkers::new(PATIENCE), Instant::now());
        for life in [1, 2] {
            let name = WorkerId::new("far").expect("a name");
            lives.sign(name, SessionId(life), true, begun);
            lives.leaves(SessionId(1));
        }
        assert!(lives.tick(begun + Duration::from_secs(3_600)).is_empty());
    }

    #[test]
    fn a_link_that_flaps_is_counted_and_a_sign_that_is_seen_again_is_not() {
        let steps = [(0, Some((1, true))), (1, Some((1, true))), (2, Some((9, false)))];
        let (_, lives) = told(&steps);
        assert_eq!((lives.lost, lives.back, lives.up.len()), (0, 0, 1));
        let flap = [(3, Some((1, false))), (3, Some((1, false))), (4, Some((1, true)))];
        let (_, lives) = told(&[&steps[..], &flap].concat());
        assert_eq!((lives.lost, lives.back, lives.up.len()), (1, 1, 1));
    }

    #[test]
    fn signs_of_one_name_are_bounded() {
        let steps: Vec<_> = (0..40).map(|life| (0, Some((life, true)))).collect();
        let (_, lives) = told(&steps);
        assert_eq!(lives.up.len(), super::MAX_OF_NAME);
        let (_, lives) =
            told(&[&steps[..], &[(1, Some((3, false))), (2, Some((39, true)))]].concat());
        assert!(!lives.up.contains(&SessionId(39)) && !lives.up.contains(&SessionId(3)));
        assert!(lives.up.contains(&SessionId(16)), "it has waited longest");
        assert_eq!(lives.up.len(), super::MAX_OF_NAME);
        // One that went before its turn never comes.
        let gone = [(1, Some((16, false))), (2, Some((3, false))), (3, Some((4, false)))];
        let (_, lives) = told(&[&steps[..], &gone].concat());
        assert!(!lives.up.contains(&SessionId(16)) && lives.up.contains(&SessionId(18)));
    }

    #[test]
    fn signs_of_all_names_are_bounded() {
        let (mut lives, begun) = (LiveWorkers::new(PATIENCE), Instant::now());
        let name = |life: u64| WorkerId::new(&format!("w{life}")).expect("a name");
        let most = super::MAX_SESSIONS as u64;
        for life in 0..most + 2 * super::MAX_WAITING as u64 {
            lives.sign(name(life), SessionId(life), true, begun);
        }
        let waits = super::MAX_WAITING;
        assert_eq!((lives.up.len(), lives.waiting.len()), (most as usize, waits));
        lives.sign(name(9), SessionId(9), false, begun);
        assert!(lives.up.len() == most as usize && lives.up.contains(&SessionId(most)));
        assert_eq!(lives.waiting.len(), waits - 1);
    }
}
