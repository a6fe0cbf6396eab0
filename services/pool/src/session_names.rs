//! Which name each session has. A certificate proves a name; that a session is of that name is
//! remembered from the worker's first word on, and nobody else speaks for it.

use cullet_dispatch::{Worker, WorkerName};
use cullet_proto::pool::QuestionRefusal;
use cullet_proto::{SessionId, WorkerId, ids};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Sessions of one name at a time: one at work, and those of before a restart or two whose links
/// are not given up yet.
const MAX_OF_NAME: usize = 4;
/// Sessions remembered; beyond it those whose link is down are forgotten, and where there are none
/// nobody else is let in.
pub(super) const MAX_SESSIONS: usize = 4_096;

/// Which name each session has.
#[derive(Debug, Default)]
pub(super) struct SessionNames {
    names: BTreeMap<Worker, WorkerId>,
    /// The sessions of each name, the oldest first.
    sessions: BTreeMap<WorkerId, VecDeque<Worker>>,
}

impl SessionNames {
    /// What a session is called, if it has said hello.
    pub(super) fn name(&self, worker: Worker) -> Option<&WorkerId> {
        self.names.get(&worker)
    }

    /// Refuses whoever speaks for a session of another name.
    pub(super) fn check(&self, worker: Worker, name: &WorkerId) -> Result<(), QuestionRefusal> {
        match self.names.get(&worker) {
            Some(owner) if owner != name => Err(QuestionRefusal::Foreign),
            _ => Ok(()),
        }
    }

    /// A session is of this name from now on; those that are forgotten for it.
    pub(super) fn bind(
        &mut self,
        worker: Worker,
        name: &WorkerId,
        up: &BTreeSet<SessionId>,
    ) -> Result<Vec<Worker>, QuestionRefusal> {
        self.check(worker, name)?;
        if self.names.contains_key(&worker) {
            return Ok(Vec::new());
        }
        let away = |worker: &Worker| !up.contains(&SessionId(worker.0));
        let own = self.sessions.get(name);
        let mut forgotten = Vec::new();
        if own.is_some_and(|own| own.len() >= MAX_OF_NAME) {
            let oldest = own.into_iter().flatten().copied().find(away);
            let limit = MAX_OF_NAME as u64;
            forgotten.push(oldest.ok_or(QuestionRefusal::TooManySessions { limit })?);
        } else if self.names.len() >= MAX_SESSIONS {
            forgotten.extend(self.names.keys().copied().filter(away));
            if forgotten.is_empty() {
                let limit = MAX_SESSIONS as u64;
                return Err(QuestionRefusal::TooManySessions { limit });
            }
        }
        forgotten.iter().for_each(|worker| self.forget(*worker));
        self.names.insert(worker, name.clone());
        self.sessions.entry(name.clone()).or_default().push_back(worker);
        Ok(forgotten)
    }

    /// A session is over.
    pub(super) fn forget(&mut self, worker: Worker) {
        let Some(name) = self.names.remove(&worker) else { return };
        if let Some(own) = self.sessions.get_mut(&name) {
            own.retain(|known| *known != worker);
            if own.is_empty() {
                self.sessions.remove(&name);
            }
        }
    }

    /// The sessions of a name.
    pub(super) fn of(&self, name: &str) -> Vec<Worker> {
        let own = WorkerId::new(name).ok().and_then(|name| self.sessions.get(&name));
        own.into_iter().flatten().copied().collect()
    }
}

/// A name as the machine knows it.
pub(super) fn number(name: &WorkerId) -> WorkerName {
    let hashed = ids::digest(name.as_str().as_bytes());
    WorkerName(u64::from_le_bytes([0, 1, 2, 3, 4, 5, 6, 7].map(|at| hashed[at])))
}

#[cfg(test)]
mod tests {
    use super::{MAX_OF_NAME, MAX_SESSIONS, SessionNames};
    use cullet_dispatch::Worker;
    use cullet_proto::pool::QuestionRefusal;
    use cullet_proto::{SessionId, WorkerId};
    use std::collections::BTreeSet;

    fn name(text: &str) -> WorkerId {
        WorkerId::new(text).expect("a name")
    }

    #[test]
    fn a_session_is_of_the_name_that_said_hello_with_it_and_of_no_other() {
        let (mut known, up) = (SessionNames::default(), BTreeSet::new());
        assert_eq!(known.bind(Worker(7), &name("honest"), &up), Ok(Vec::new()));
        assert_eq!(known.bind(Worker(7), &name("honest"), &up), Ok(Vec::new()));
        assert_eq!(known.bind(Worker(7), &name("evil"), &up), Err(QuestionRefusal::Foreign));
        assert_eq!(known.check(Worker(7), &name("evil")), Err(QuestionRefusal::Foreign));
        assert_eq!(known.check(Worker(7), &name("honest")), Ok(()));
        assert_eq!(known.of("honest"), [Worker(7)]);
        known.forget(Worker(7));
        assert_eq!(known.bind(Worker(7), &name("evil"), &up), Ok(Vec::new()));
    }

    #[test]
    fn a_name_has_four_sessions_and_makes_room_by_those_that_are_gone() {
        let mut known = SessionNames::default();
        let mut up: BTreeSet<SessionId> = (0..MAX_OF_NAME as u64).map(SessionId).collect();
        for session in 0..MAX_OF_NAME as u64 {
            assert_eq!(known.bind(Worker(session), &name("w"), &up), Ok(Vec::new()));
        }
        let refused = Err(QuestionRefusal::TooManySessions { limit: 4 });
        assert_eq!(known.bind(Worker(9), &name("w"), &up), refused);
        assert_eq!(known.bind(Worker(10), &name("v"), &up), Ok(Vec::new()), "another's room");
        up.remove(&SessionId(2));
        assert_eq!(known.bind(Worker(9), &name("w"), &up), Ok(vec![Worker(2)]));
        assert_eq!(known.of("w"), [0, 1, 3, 9].map(Worker));
    }

    #[test]
    fn sessions_of_many_names_are_bounded_by_those_that_are_gone() {
        let (mut known, up) = (SessionNames::default(), BTreeSet::from([SessionId(3)]));
        for session in 0..MAX_SESSIONS as u64 {
            let own = name(&format!("w{session}"));
            assert_eq!(known.bind(Worker(session), &own, &up), Ok(Vec::new()));
        }
        let gone = known.bind(Worker(u64::MAX), &name("last"), &up).expect("there is room");
        assert_eq!(gone.len(), MAX_SESSIONS - 1);
        assert!(known.name(Worker(3)).is_some() && known.name(Worker(4)).is_none());
    }

    #[test]
    fn where_as_many_sessions_as_may_be_are_there_nobody_else_is_let_in() {
        let mut known = SessionNames::default();
        let mut up: BTreeSet<SessionId> = (0..=MAX_SESSIONS as u64).map(SessionId).collect();
        for session in 0..MAX_SESSIONS as u64 {
            let own = name(&format!("w{session}"));
            assert_eq!(known.bind(Worker(session), &own, &up), Ok(Vec::new()));
        }
        let (last, limit) = (Worker(MAX_SESSIONS as u64), MAX_SESSIONS as u64);
        let refused = Err(QuestionRefusal::TooManySessions { limit });
        assert_eq!(known.bind(last, &name("last"), &up), refused);
        assert_eq!((known.name(last), known.of("last")), (None, Vec::new()));
        assert_eq!(known.bind(Worker(7), &name("w7"), &up), Ok(Vec::new()), "it is known");
        up.remove(&SessionId(7));
        assert_eq!(known.bind(last, &name("last"), &up), Ok(vec![Worker(7)]));
    }
}
