//! Key expressions. `v1` is the wire's major version; names are [`WorkerId`]s.

use crate::ids::{SessionId, WorkerId};

/// The root of everything.
pub const ROOT: &str = "cullet/v1";
/// The name of a coordinator that was given none.
pub const DEFAULT_COORDINATOR: &str = "main";

/// What a worker may ask.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorkerVerb {
    /// To know it.
    Hello,
    /// For a job.
    Poll,
    /// To go on.
    Renew,
    /// To be told as soon as its job is not wanted any more.
    Heed,
    /// For a piece of the job.
    Fetch,
    /// To take a piece of the result.
    Chunk,
    /// To count the result.
    Commit,
    /// To take a job back.
    Fail,
    /// To leave.
    Bye,
}

/// What a person or a program may ask; [`crate::service`] has the questions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UserVerb {
    /// What the coordinator is and has.
    About,
    /// To take a piece of a bundle.
    Piece,
    /// To run a bundle.
    Submit,
    /// For all runs.
    Runs,
    /// For one run.
    Run,
    /// How it goes on.
    Follow,
    /// To end it.
    Cancel,
    /// To lay it aside.
    Pause,
    /// To take it up again.
    Resume,
    /// To put one that is over back into the queue.
    Retry,
    /// To remove one that is over, with all that it left.
    Delete,
    /// For a piece of a file of it.
    Fetch,
    /// To expect no more questions about it.
    Bye,
    /// For all workers.
    Workers,
    /// To give a worker no more jobs.
    Drain,
}

/// A question, by its key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verb {
    /// Of a worker.
    Worker(WorkerId, WorkerVerb),
    /// Of a client.
    User(WorkerId, UserVerb),
}

const WORKER_VERBS: [(&str, WorkerVerb); 9] = [
    ("hello", WorkerVerb::Hello),
    ("poll", WorkerVerb::Poll),
    ("renew", WorkerVerb::Renew),
    ("heed", WorkerVerb::Heed),
    ("fetch", WorkerVerb::Fetch),
    ("chunk", WorkerVerb::Chunk),
    ("commit", WorkerVerb::Commit),
    ("fail", WorkerVerb::Fail),
    ("bye", WorkerVerb::Bye),
];

const USER_VERBS: [(&str, UserVerb); 15] = [
    ("about", UserVerb::About),
    ("piece", UserVerb::Piece),
    ("submit", UserVerb::Submit),
    ("runs", UserVerb::Runs),
    ("run", UserVerb::Run),
    ("follow", UserVerb::Follow),
    ("cancel", UserVerb::Cancel),
    ("pause", UserVerb::Pause),
    ("resume", UserVerb::Resume),
    ("retry", UserVerb::Retry),
    ("delete", UserVerb::Delete),
    ("fetch", UserVerb::Fetch),
    ("bye", UserVerb::Bye),
    ("workers", UserVerb::Workers),
    ("drain", UserVerb::Drain),
];

impl WorkerVerb {
    /// Its word in a key.
    #[must_use]
    pub fn word(self) -> &'static str {
        WORKER_VERBS.iter().find(|(_, verb)| *verb == self).map_or("", |(word, _)| word)
    }
}

impl UserVerb {
    /// Its word in a key.
    #[must_use]
    pub fn word(self) -> &'static str {
        USER_VERBS.iter().find(|(_, verb)| *verb == self).map_or("", |(word, _)| word)
    }
}

/// All questions of workers to a coordinator.
#[must_use]
pub fn worker_rpcs(coordinator: &WorkerId) -> String {
    format!("{ROOT}/c/{coordinator}/rpc/w/**")
}

/// All questions of clients to a coordinator.
#[must_use]
pub fn user_rpcs(coordinator: &WorkerId) -> String {
    format!("{ROOT}/c/{coordinator}/rpc/u/**")
}

/// All questions of one worker.
#[must_use]
pub fn worker_rpcs_of(coordinator: &WorkerId, worker: &WorkerId) -> String {
    format!("{ROOT}/c/{coordinator}/rpc/w/{worker}/**")
}

/// All questions of one client.
#[must_use]
pub fn user_rpcs_of(coordinator: &WorkerId, user: &WorkerId) -> String {
    format!("{ROOT}/c/{coordinator}/rpc/u/{user}/**")
}

/// All questions of workers with one certificate: they are called as it is, a dash, and more.
#[must_use]
pub fn crew_rpcs(coordinator: &WorkerId, certificate: &WorkerId) -> String {
    format!("{ROOT}/c/{coordinator}/rpc/w/{certificate}-$*/**")
}

/// All signs of life of those.
#[must_use]
pub fn crew_lives(coordinator: &WorkerId, certificate: &WorkerId) -> String {
    format!("{ROOT}/live/w/{coordinator}/{certificate}-$*/*")
}

/// All signs of life of one worker for a coordinator.
#[must_use]
pub fn worker_lives(coordinator: &WorkerId, worker: &WorkerId) -> String {
    format!("{ROOT}/live/w/{coordinator}/{worker}/*")
}

/// One question of a worker.
#[must_use]
pub fn worker_rpc(coordinator: &WorkerId, worker: &WorkerId, verb: WorkerVerb) -> String {
    format!("{ROOT}/c/{coordinator}/rpc/w/{worker}/{}", verb.word())
}

/// One question of a client.
#[must_use]
pub fn user_rpc(coordinator: &WorkerId, user: &WorkerId, verb: UserVerb) -> String {
    format!("{ROOT}/c/{coordinator}/rpc/u/{user}/{}", verb.word())
}

/// The sign of life of a worker for a coordinator.
#[must_use]
pub fn worker_live(coordinator: &WorkerId, worker: &WorkerId, session: SessionId) -> String {
    format!("{ROOT}/live/w/{coordinator}/{worker}/{session}")
}

/// The signs of life of all workers for a coordinator.
#[must_use]
pub fn workers_live(coordinator: &WorkerId) -> String {
    format!("{ROOT}/live/w/{coordinator}/*/*")
}

/// The worker and its life that a sign of life speaks of.
#[must_use]
pub fn parse_live(key: &str) -> Option<(WorkerId, SessionId)> {
    let mut parts = key.strip_prefix(ROOT)?.strip_prefix("/live/w/")?.split('/');
    let (_, worker, session) = (parts.next()?, parts.next()?, parts.next()?);
    let session = u64::from_str_radix(session, 16).ok()?;
    let end = parts.next().is_none();
    end.then_some((WorkerId::new(worker).ok()?, SessionId(session)))
}

/// The sign of life of one life of a coordinator.
#[must_use]
pub fn coordinator_live(coordinator: &WorkerId, life: SessionId) -> String {
    format!("{ROOT}/live/c/{coordinator}/{life}")
}

/// The signs of life of all coordinators of one name.
#[must_use]
pub fn coordinators_live(coordinator: &WorkerId) -> String {
    format!("{ROOT}/live/c/{coordinator}/*")
}

/// The life of a coordinator that a sign of life speaks of.
#[must_use]
pub fn parse_coordinator_live(key: &str) -> Option<SessionId> {
    let mut parts = key.strip_prefix(ROOT)?.strip_prefix("/live/c/")?.split('/');
    let (_, life) = (parts.next()?, parts.next()?);
    let life = u64::from_str_radix(life, 16).ok()?;
    parts.next().is_none().then_some(SessionId(life))
}

/// Where one life of a coordinator is asked for its [claim](crate::claim).
#[must_use]
pub fn claim(coordinator: &WorkerId, life: SessionId) -> String {
    format!("{ROOT}/c/{coordinator}/claim/{life}")
}

/// Where all coordinators of one name are asked for theirs.
#[must_use]
pub fn claims(coordinator: &WorkerId) -> String {
    format!("{ROOT}/c/{coordinator}/claim/*")
}

/// The question that a key asks.
#[must_use]
pub fn parse_rpc(key: &str) -> Option<Verb> {
    let mut parts = key.strip_prefix(ROOT)?.strip_prefix("/c/")?.split('/');
    let (_, rpc, side) = (parts.next()?, parts.next()?, parts.next()?);
    let (name, word) = (WorkerId::new(parts.next()?).ok()?, parts.next()?);
    if rpc != "rpc" || parts.next().is_some() {
        return None;
    }
    match side {
        "w" => {
            let (_, verb) = WORKER_VERBS.iter().find(|(known, _)| *known == word)?;
            Some(Verb::Worker(name, *verb))
        }
        "u" => {
            let (_, verb) = USER_VERBS.iter().find(|(known, _)| *known == word)?;
            Some(Verb::User(name, *verb))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_come_back_from_their_text() -> Result<(), crate::WireError> {
        let (main, w) = (WorkerId::new("main")?, WorkerId::new("w-1")?);
        for (_, verb) in WORKER_VERBS {
            let key = worker_rpc(&main, &w, verb);
            assert_eq!(parse_rpc(&key), Some(Verb::Worker(w.clone(), verb)));
        }
        for (_, verb) in USER_VERBS {
            let key = user_rpc(&main, &w, verb);
            assert_eq!(parse_rpc(&key), Some(Verb::User(w.clone(), verb)));
        }
        let live = worker_live(&main, &w, SessionId(0xfe));
        assert_eq!(parse_live(&live), Some((w.clone(), SessionId(0xfe))));
        let live = coordinator_live(&main, SessionId(0xfe));
        assert_eq!(parse_coordinator_live(&live), Some(SessionId(0xfe)));
        assert_eq!(parse_coordinator_live(&worker_live(&main, &w, SessionId(0xfe))), None);
        assert_eq!(parse_live(&live), None);
        for bad in ["", "cullet/v1/c/main/rpc/w/w-1", "cullet/v2/c/main/rpc/w/w-1/poll"] {
            assert_eq!(parse_rpc(bad), None, "{bad}");
        }
        assert_eq!(parse_rpc("cullet/v1/c/main/rpc/w/W/poll"), None);
        assert_eq!(parse_rpc("cullet/v1/c/main/rpc/w/w/poll/more"), None);
        Ok(())
    }
}
