//! Jobs that start from another's result: the worker that found it is preferred, and nobody waits
//! for it.

use crate::common;

use common::*;
use cullet_dispatch::*;

/// Worker 1 has found the result of job 1; worker 2 has waited longer than worker 1.
fn after_the_first() -> Pool {
    let mut pool = Pool::new();
    pool.begin(1, 1, 4);
    pool.open(1, 1);
    let first = pool.ask(1).expect("a job");
    assert!(pool.ask(2).is_none());
    pool.done(1, first);
    pool
}

fn to_whom(said: &[Effect]) -> Vec<(u64, Job)> {
    let grant = |effect: &Effect| match effect {
        Effect::Grant { worker, job, .. } => Some((worker.0, *job)),
        _ => None,
    };
    said.iter().filter_map(grant).collect()
}

#[test]
fn a_job_goes_to_who_made_what_it_starts_from_and_others_to_who_waited_longest() {
    let mut pool = after_the_first();
    assert!(pool.ask(1).is_none());
    assert_eq!(to_whom(&pool.open_after(1, 2, 1)), [(1, job(2))]);
    assert_eq!(to_whom(&pool.open(1, 3)), [(2, job(3))]);
    // A chain: each window to the maker of the one before.
    let mut pool = after_the_first();
    assert!(pool.ask(1).is_none());
    for k in 2..10 {
        let said = pool.open_after(1, k, k - 1);
        let grant = granted(&said, Worker(1)).expect("the maker has it");
        pool.done(1, grant);
        assert!(pool.ask(1).is_none());
    }
    // Of what is not known there is no maker.
    assert_eq!(to_whom(&pool.open_after(1, 177, 77)), [(2, job(177))]);
    // Nor of what is not done.
    assert!(pool.ask(3).is_none());
    assert_eq!(to_whom(&pool.open_after(1, 178, 177)), [(1, job(178))]);
}

#[test]
fn nobody_waits_for_a_maker() {
    // It has not asked.
    let mut pool = after_the_first();
    assert_eq!(to_whom(&pool.open_after(1, 2, 1)), [(2, job(2))]);
    // It has something else to do.
    let mut pool = after_the_first();
    assert!(pool.ask(3).is_none());
    assert_eq!(to_whom(&pool.open(1, 5)), [(2, job(5))]);
    assert!(pool.ask(2).is_none());
    assert_eq!(to_whom(&pool.open(1, 6)), [(3, job(6))]);
    assert_eq!(to_whom(&pool.open_after(1, 2, 1)), [(2, job(2))]);
    // It is gone, or drained.
    for end in [Event::Down(Worker(1)), Event::Bye(Worker(1)), Event::Drain(Worker(1))] {
        let mut pool = after_the_first();
        assert!(pool.ask(1).is_none());
        pool.step(end);
        assert_eq!(to_whom(&pool.open_after(1, 2, 1)), [(2, job(2))], "{end:?}");
    }
}

#[test]
fn a_maker_gets_nothing_that_it_cannot_do_or_that_died_under_it() {
    let mut pool = Pool::new();
    pool.begin(1, 1, 4);
    pool.open(1, 1);
    let weak = Skills(0b01);
    let first = granted(&pool.step(poll(Worker(1), 1, weak)), Worker(1)).expect("a job");
    pool.seq = 10;
    assert!(pool.ask(2).is_none());
    pool.done(1, first);
    pool.step(poll(Worker(1), 2, weak));
    let (need, after, prior) = (Skills(0b10), Some(job(1)), Prior::Nothing);
    let said = pool.step(Event::Open { run: Run(1), job: job(2), need, after, prior });
    assert_eq!(to_whom(&said), [(2, job(2))]);

    let mut pool = after_the_first();
    assert!(pool.ask(1).is_none());
    let grant = granted(&pool.open_after(1, 2, 1), Worker(1)).expect("the maker has it");
    let (worker, trouble) = (Worker(1), Trouble::Crashed);
    pool.step(Event::Fail { worker, job: grant.0, epoch: grant.1, trouble });
    assert!(pool.ask(1).is_none());
    assert_eq!(to_whom(&pool.pass(1_000)), [(2, job(2))]);
}

/// The line of runs decides which job is next, as if nobody had made anything.
#[test]
fn a_preference_says_who_and_not_which() {
    let mut pool = after_the_first();
    pool.begin(2, 2, 9);
    for k in 20..24 {
        pool.open(2, k);
    }
    // Worker 2 has the first of them; run 1 has had worker time, run 2 has not.
    pool.open_after(1, 2, 1);
    let got = pool.ask(1).map(|(job, _)| job);
    let mut plain = after_the_first();
    plain.begin(2, 2, 9);
    for k in 20..24 {
        plain.open(2, k);
    }
    plain.open(1, 2);
    assert_eq!(got, plain.ask(1).map(|(job, _)| job));
    assert!(got.is_some());
}

/// A second run finds the first's result in the cache: who made it still has it.
#[test]
fn a_result_from_the_cache_does_not_hide_its_maker() {
    let mut pool = after_the_first();
    assert!(pool.ask(1).is_none());
    pool.begin(2, 1, 4);
    let (digest, outcome, build) = (Digest(job(1).0), Outcome::Broken, Some(BUILD));
    let prior = Prior::Result { digest, outcome, build };
    let (need, after) = (Skills::NONE, None);
    let said = pool.step(Event::Open { run: Run(2), job: job(1), need, after, prior });
    assert!(said.iter().any(|effect| matches!(effect, Effect::Settle { .. })), "{said:?}");
    assert_eq!(to_whom(&pool.open_after(2, 2, 1)), [(1, job(2))]);
}
