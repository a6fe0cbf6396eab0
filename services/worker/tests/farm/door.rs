//! Bytes that are not as they should be get an answer that says so.

use crate::kit::{HiredWorker, answer, config, job, next, solve, verdict, wait_for};
use cullet_pool::{CacheConfig, JobEnding, Pool, PoolConfig, Refusals, Share};
use cullet_proto::ids::digest;
use cullet_proto::keys::{self, WorkerVerb};
use cullet_proto::pool::{
    self, Acknowledged, Bye, Chunk, ChunkAnswer, Commit, CommitAnswer, Fail, GiveBackReason, Grant,
    Heed, Hello, Poll, PollAnswer, QuestionRefusal, Renew, RenewAnswer,
};
use cullet_proto::transport::{self, Patience};
use cullet_proto::{SessionId, WorkerId, chunks};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::sync::Arc;
use std::time::Duration;
use zenoh::Wait;

/// A worker that says what a test wants it to say.
struct Forger {
    link: zenoh::Session,
    called: &'static str,
    _alive: zenoh::liveliness::LivelinessToken,
}

impl Forger {
    fn of(pool: &Pool) -> Self {
        Self::life(pool, SessionId(9))
    }

    fn life(pool: &Pool, session: SessionId) -> Self {
        let forger = Self::named(pool, "forger", session);
        let hello = Hello { session, ..Hello::default() };
        let _: Acknowledged = forger.ask(WorkerVerb::Hello, &hello, &[]);
        forger
    }

    /// One of that name, which has said nothing yet.
    fn named(pool: &Pool, called: &'static str, session: SessionId) -> Self {
        let mut settings = zenoh::Config::default();
        for (path, value) in transport::worker(&[pool.endpoint().to_owned()], Patience::test()) {
            settings.insert_json5(path, &value).expect("a setting");
        }
        let link = zenoh::open(settings).wait().expect("a session");
        let name = |text| WorkerId::new(text).expect("a name");
        let key = keys::worker_live(&name("main"), &name(called), session);
        let _alive = link.liveliness().declare_token(key).wait().expect("a sign of life");
        Self { link, called, _alive }
    }

    fn raw(&self, verb: WorkerVerb, bytes: &[u8]) -> Result<Vec<u8>, QuestionRefusal> {
        let name = |text| WorkerId::new(text).expect("a name");
        let key = keys::worker_rpc(&name("main"), &name(self.called), verb);
        for _ in 0..50 {
            let get = self.link.get(&key).payload(bytes).timeout(Duration::from_secs(5));
            match get.wait().ok().and_then(|replies| replies.recv().ok()) {
                Some(reply) => {
                    return match reply.into_result() {
                        Ok(sample) => Ok(sample.payload().to_bytes().into_owned()),
                        Err(error) => {
                            let bytes = error.payload().to_bytes().into_owned();
                            Err(pool::read_refusal(&bytes).expect("a typed refusal"))
                        }
                    };
                }
                None => std::thread::sleep(Duration::from_millis(50)),
            }
        }
        panic!("no answer");
    }

    fn ask<Q: Serialize, A: DeserializeOwned>(&self, verb: WorkerVerb, ask: &Q, bulk: &[u8]) -> A {
        let bytes = pool::ask(ask, bulk).expect("a question");
        let bytes = self.raw(verb, &bytes).expect("an answer");
        pool::read_answer(&bytes).expect("a readable answer").0
    }
}

#[test]
fn old_oversized_and_garbled_questions_are_refused_by_type() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let forger = Forger::of(&pool);
    let poll = Poll { session: SessionId(9), seq: 1, slots: 1, threads: 1 };
    let good = pool::ask(&poll, &[]).expect("a question");
    let mut old = good.clone();
    old[4] = 0;
    assert_eq!(forger.raw(WorkerVerb::Poll, &old), Err(QuestionRefusal::Unsupported { ours: 1 }));
    let large = pool::ask(&poll, &vec![0; 2 * chunks::CHUNK]).expect("a question");
    assert!(matches!(
        forger.raw(WorkerVerb::Poll, &large),
        Err(QuestionRefusal::TooLarge { limit, .. }) if limit < 2 << 20
    ));
    let mut garbled = good;
    garbled[22] ^= 1;
    let refusal = forger.raw(WorkerVerb::Renew, &garbled);
    assert!(matches!(&refusal, Err(QuestionRefusal::Malformed(text)) if text.contains("checksum")));
    let counted = Refusals { unsupported: 1, too_large: 1, malformed: 1, ..Refusals::default() };
    wait_for("they are counted", || pool.stats().refusals == counted);
}

#[test]
fn a_damaged_chunk_is_sent_again_and_a_false_digest_never_settles() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let forger = Forger::of(&pool);
    let session = SessionId(9);
    let problem = job("echo", 3, 0);
    let id = run.open(&problem);
    let poll = Poll { session, seq: 1, slots: 1, threads: 1 };
    let PollAnswer::Grant(grant) = forger.ask(WorkerVerb::Poll, &poll, &[]) else {
        panic!("no grant")
    };
    // The same question again gets the same grant.
    let again: PollAnswer = forger.ask(WorkerVerb::Poll, &poll, &[]);
    assert!(matches!(again, PollAnswer::Grant(g) if g.epoch == grant.epoch));
    let blob = answer(&problem).encode().expect("a verdict");
    let (name, length, sum) = (digest(&blob), blob.len() as u64, chunks::sum(&blob));
    let chunk = Chunk { digest: name, length, index: 0, sum };
    let mut damaged = blob.clone();
    damaged[30] ^= 4;
    let said: ChunkAnswer = forger.ask(WorkerVerb::Chunk, &chunk, &damaged);
    assert_eq!(said, ChunkAnswer::Damaged);
    let (job, epoch) = (grant.job, grant.epoch);
    let commit = Commit { session, job, epoch, digest: name, length, next: None };
    let said: CommitAnswer = forger.ask(WorkerVerb::Commit, &commit, &[]);
    assert_eq!(said, CommitAnswer::Missing(vec![0]));
    // A false checksum gets past the first test, and is caught by the digest.
    let forged = Chunk { sum: chunks::sum(&damaged), ..chunk };
    let said: ChunkAnswer = forger.ask(WorkerVerb::Chunk, &forged, &damaged);
    assert_eq!(said, ChunkAnswer::Have);
    let said: CommitAnswer = forger.ask(WorkerVerb::Commit, &commit, &[]);
    assert_eq!(said, CommitAnswer::Damaged);
    assert!(run.settled(Duration::from_millis(50)).is_none());
    let said: ChunkAnswer = forger.ask(WorkerVerb::Chunk, &chunk, &blob);
    assert_eq!(said, ChunkAnswer::Have);
    for _ in 0..2 {
        let said: CommitAnswer = forger.ask(WorkerVerb::Commit, &commit, &[]);
        assert_eq!(said, CommitAnswer::Done(None));
    }
    assert_eq!(verdict(next(&run, id)), answer(&problem));
    // Another result of the same job is not taken, and not kept quiet.
    let other = Commit { digest: [7; 32], ..commit };
    let said: CommitAnswer = forger.ask(WorkerVerb::Commit, &other, &[]);
    assert_eq!(said, CommitAnswer::Done(None));
    wait_for("the alarm", || pool.stats().alarms == 1);
}

#[test]
fn a_worker_that_takes_a_job_and_falls_silent_loses_it_to_another() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let forger = Forger::of(&pool);
    let poll = Poll { session: SessionId(9), seq: 1, slots: 1, threads: 1 };
    let id = run.open(&job("echo", 3, 0));
    let said: PollAnswer = forger.ask(WorkerVerb::Poll, &poll, &[]);
    assert!(matches!(said, PollAnswer::Grant(_)));
    let _hand = HiredWorker::hire(&pool, "w", Arc::new(solve));
    let settlement = next(&run, id);
    assert_eq!((settlement.attempts, settlement.worker.as_str()), (2, "w"));
}

#[test]
fn a_worker_that_vanishes_is_charged_to_a_job_that_its_solver_has_and_to_no_other() {
    // Whether it says that its solver has the job, and that it has a result; whether it is charged.
    for (permille, offers, charged) in [(0, false, false), (1, false, true), (1, true, false)] {
        let pool = Pool::start(config()).expect("a pool on loopback");
        let run = pool.run(Share::default());
        let id = run.open(&job("echo", 3, 0));
        for life in 1..=3 {
            let session = SessionId(life);
            let forger = Forger::life(&pool, session);
            wait_for("it is seen", || pool.stats().workers == 1);
            let poll = Poll { session, seq: 1, slots: 1, threads: 1 };
            let PollAnswer::Grant(grant) = forger.ask(WorkerVerb::Poll, &poll, &[]) else {
                panic!("no grant")
            };
            let renew = Renew { session, job: grant.job, epoch: grant.epoch, permille };
            let said: RenewAnswer = forger.ask(WorkerVerb::Renew, &renew, &[]);
            assert!(matches!(said, RenewAnswer::Go { .. }));
            if offers {
                let (job, epoch, digest, length, next) = (grant.job, grant.epoch, [5; 32], 9, None);
                let commit = Commit { session, job, epoch, digest, length, next };
                let said: CommitAnswer = forger.ask(WorkerVerb::Commit, &commit, &[]);
                assert_eq!(said, CommitAnswer::Missing(vec![0]));
            }
            drop(forger);
            wait_for("it is missed", || pool.stats().workers == 0);
            wait_for("it has lost the job", || pool.stats().jobs.running == 0);
        }
        let _hand = HiredWorker::hire(&pool, "w", Arc::new(solve));
        let settlement = next(&run, id);
        let abandoned = matches!(settlement.ending, JobEnding::Abandoned(_));
        assert_eq!(abandoned, charged, "{settlement:?}");
        assert_eq!(settlement.attempts, if abandoned { 3 } else { 4 });
    }
}

#[test]
fn a_late_result_of_another_build_is_fenced_and_a_stranger_is_asked_who_it_is() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let forger = Forger::of(&pool);
    let poll = |session| Poll { session: SessionId(session), seq: 1, slots: 1, threads: 1 };
    let stranger = pool::ask(&poll(8), &[]).expect("a question");
    assert_eq!(forger.raw(WorkerVerb::Poll, &stranger), Err(QuestionRefusal::Stranger));
    let problem = job("echo", 3, 1_000);
    let id = run.open(&problem);
    let said: PollAnswer = forger.ask(WorkerVerb::Poll, &poll(9), &[]);
    let PollAnswer::Grant(Grant { job, epoch, .. }) = said else { panic!("no grant: {said:?}") };
    let _hand = HiredWorker::hire(&pool, "w", Arc::new(solve));
    wait_for("another has it", || pool.stats().jobs.resent == 1);
    // What it hands in was right, and nobody can know that.
    let blob = answer(&problem).encode().expect("a verdict");
    let (digest, length, session) = (digest(&blob), blob.len() as u64, SessionId(9));
    let commit = Commit { session, job, epoch, digest, length, next: None };
    let said: CommitAnswer = forger.ask(WorkerVerb::Commit, &commit, &[]);
    assert_eq!(said, CommitAnswer::Done(None));
    wait_for("it is counted", || pool.stats().fenced == 1);
    assert_eq!(next(&run, id).worker, "w");
    // Now it is the same as what counts.
    let said: CommitAnswer = forger.ask(WorkerVerb::Commit, &commit, &[]);
    assert_eq!(said, CommitAnswer::Done(None));
    let stats = pool.stats();
    assert_eq!((stats.fenced, stats.alarms), (1, 0));
}

/// As much as while the job is remembered, whether the next life has opened it again or not.
#[test]
fn a_late_result_that_differs_from_a_kept_one_raises_the_alarm_in_the_next_life_too() {
    let folder = tempfile::tempdir().expect("a folder");
    let disk = Some((folder.path().to_owned(), 1 << 20));
    let cache = CacheConfig { disk, ..CacheConfig::default() };
    let start = || Pool::start(PoolConfig { cache: cache.clone(), ..config() }).expect("a pool");
    let (problem, session) = (job("echo", 3, 0), SessionId(9));
    let pool = start();
    let run = pool.run(Share::default());
    let id = run.open(&problem);
    let forger = Forger::of(&pool);
    let poll = Poll { session, seq: 1, slots: 1, threads: 1 };
    let PollAnswer::Grant(grant) = forger.ask(WorkerVerb::Poll, &poll, &[]) else {
        panic!("no grant")
    };
    let blob = answer(&problem).encode().expect("a verdict");
    let (name, length, sum) = (digest(&blob), blob.len() as u64, chunks::sum(&blob));
    let chunk = Chunk { digest: name, length, index: 0, sum };
    let (job, epoch) = (grant.job, grant.epoch);
    let commit = Commit { session, job, epoch, digest: name, length, next: None };
    let _: CommitAnswer = forger.ask(WorkerVerb::Commit, &commit, &[]);
    let _: ChunkAnswer = forger.ask(WorkerVerb::Chunk, &chunk, &blob);
    let _: CommitAnswer = forger.ask(WorkerVerb::Commit, &commit, &[]);
    verdict(next(&run, id));
    pool.shutdown();
    for opened in [false, true] {
        let pool = start();
        let run = pool.run(Share::default());
        if opened {
            run.open(&problem);
            assert!(next(&run, id).cached);
        }
        let late = Forger::of(&pool);
        let other = Hello { session: SessionId(10), build: [1; 32], ..Hello::default() };
        let _: Acknowledged = late.ask(WorkerVerb::Hello, &other, &[]);
        // The same, another, and another by another build.
        for (session, digest, want) in
            [(session, name, (0, 0)), (session, [5; 32], (1, 0)), (other.session, [5; 32], (1, 1))]
        {
            let said: CommitAnswer =
                late.ask(WorkerVerb::Commit, &Commit { session, digest, ..commit }, &[]);
            assert_eq!(said, CommitAnswer::Done(None), "it need not be kept");
            wait_for("it is counted", || (pool.stats().alarms, pool.stats().fenced) == want);
        }
        pool.shutdown();
    }
}

/// 2 MiB of the ends of results that nobody wants take no room and keep nobody's result out.
#[test]
fn chunks_that_nobody_asked_for_keep_the_result_of_another_worker_out_at_no_time() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let forger = Forger::of(&pool);
    let (end, length) = (vec![7; chunks::CHUNK], chunks::MAX_BLOB);
    let index = chunks::count(length) - 1;
    for name in 0..8 {
        let chunk = Chunk { digest: [name; 32], length, index, sum: chunks::sum(&end) };
        let said: ChunkAnswer = forger.ask(WorkerVerb::Chunk, &chunk, &end);
        assert_eq!(said, ChunkAnswer::Have);
    }
    let _hand = HiredWorker::hire(&pool, "honest", Arc::new(solve));
    let id = run.open(&job("echo", 3, 0));
    verdict(next(&run, id));
    pool.shutdown();
}

/// Whatever another certificate says of a session, by a question or by a sign of life, nothing
/// happens to the worker whose session it is, nor to its job.
#[test]
fn nobody_speaks_for_the_session_of_another_name() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let run = pool.run(Share::default());
    let (own, session) = (SessionId(10), SessionId(9));
    let honest = Forger::of(&pool);
    let evil = Forger::named(&pool, "evil", own);
    let problem = job("echo", 3, 0);
    let id = run.open(&problem);
    let poll = Poll { session, seq: 1, slots: 1, threads: 1 };
    let said: PollAnswer = honest.ask(WorkerVerb::Poll, &poll, &[]);
    let PollAnswer::Grant(Grant { job, epoch, .. }) = said else { panic!("no grant: {said:?}") };
    let (trouble, text) = (GiveBackReason::Crashed, "boom".to_owned());
    let fail = |session| Fail { session, job, epoch, trouble, text: text.clone() };
    let renew = |session| Renew { session, job, epoch, permille: 1 };
    let commit = Commit { session, job, epoch, digest: [5; 32], length: 9, next: None };
    let refused = [
        (WorkerVerb::Hello, pool::ask(&Hello { session, ..Hello::default() }, &[])),
        (WorkerVerb::Poll, pool::ask(&Poll { seq: 2, ..poll }, &[])),
        (WorkerVerb::Renew, pool::ask(&renew(session), &[])),
        (WorkerVerb::Heed, pool::ask(&Heed { session, job, epoch }, &[])),
        (WorkerVerb::Commit, pool::ask(&commit, &[])),
        (WorkerVerb::Fail, pool::ask(&fail(session), &[])),
        (WorkerVerb::Bye, pool::ask(&Bye { session }, &[])),
    ];
    for (verb, bytes) in &refused {
        let said = evil.raw(*verb, bytes.as_ref().expect("a question"));
        assert_eq!(said, Err(QuestionRefusal::Foreign), "{verb:?}");
    }
    // A refusal is counted when it has been said.
    wait_for("all are counted", || pool.stats().refusals.foreign == refused.len() as u64);
    // Nor by a sign of life of that session that comes and goes.
    drop(Forger::named(&pool, "evil", session));
    // As itself it gives back no job that it has not, and lets none go on.
    let hello = Hello { session: own, ..Hello::default() };
    let _: Acknowledged = evil.ask(WorkerVerb::Hello, &hello, &[]);
    let _: Acknowledged = evil.ask(WorkerVerb::Fail, &fail(own), &[]);
    let said: RenewAnswer = evil.ask(WorkerVerb::Renew, &renew(own), &[]);
    assert_eq!(said, RenewAnswer::Stop);
    std::thread::sleep(Duration::from_millis(300));
    let said: RenewAnswer = honest.ask(WorkerVerb::Renew, &renew(session), &[]);
    assert!(matches!(said, RenewAnswer::Go { .. }), "{said:?}");
    let stats = pool.stats();
    assert_eq!((stats.workers, stats.jobs.running, stats.jobs.resent), (2, 1, 0));
    let _: Acknowledged = honest.ask(WorkerVerb::Bye, &Bye { session }, &[]);
    drop((honest, evil));
    let _hand = HiredWorker::hire(&pool, "w", Arc::new(solve));
    verdict(next(&run, id));
}

#[test]
fn a_name_that_has_four_sessions_gets_no_fifth() {
    let pool = Pool::start(config()).expect("a pool on loopback");
    let mut all: Vec<Forger> = (1..=4).map(|life| Forger::life(&pool, SessionId(life))).collect();
    let fifth = Forger::named(&pool, "forger", SessionId(5));
    let hello = Hello { session: SessionId(5), ..Hello::default() };
    let bytes = pool::ask(&hello, &[]).expect("a question");
    let refused = Err(QuestionRefusal::TooManySessions { limit: 4 });
    assert_eq!(fifth.raw(WorkerVerb::Hello, &bytes), refused);
    wait_for("four are there", || pool.stats().workers == 4);
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(pool.stats().workers, 4, "one that is not let in counts for nothing");
    all.pop();
    wait_for("there is room", || fifth.raw(WorkerVerb::Hello, &bytes) != refused);
    assert_eq!(pool.workers().len(), 4, "the one that left has made room");
}
