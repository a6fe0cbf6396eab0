//! Jobs that die and workers under which jobs die: who tries them next, and what ends.

use crate::common;

use common::*;
use cullet_dispatch::*;

fn crash(pool: &mut Pool, worker: u64, (job, epoch): (Job, Epoch)) -> Vec<Effect> {
    let (worker, trouble) = (Worker(worker), Trouble::Crashed);
    pool.step(Event::Fail { worker, job, epoch, trouble })
}

#[test]
fn a_worker_under_which_others_jobs_die_is_drained() {
    let mut pool = Pool::new();
    pool.begin(1, 1, 4);
    for k in 0..3 {
        pool.open(1, k);
        let bad = pool.ask(1).expect("a job");
        crash(&mut pool, 1, bad);
        pool.pass(100);
        let good = pool.ask(2).expect("the job again");
        assert_eq!(good.0, bad.0);
        let said = pool.done(2, good);
        let away = Effect::Drained { worker: Worker(1), cause: Cause::Blamed };
        let drained = said.contains(&away);
        assert_eq!(drained, k == 2, "after {} jobs", k + 1);
    }
    pool.seq += 1;
    let seq = pool.seq;
    let said = pool.step(poll(Worker(1), seq, Skills::ALL));
    assert!(matches!(said[..], [Effect::Dismiss { .. }]));
}

#[test]
fn a_job_is_in_quarantine_after_three_crashes_on_two_workers() {
    let mut pool = Pool::new();
    pool.begin(1, 1, 4);
    pool.begin(2, 1, 4);
    // Another worker is there, and has its own to do.
    pool.open(1, 3);
    let other = pool.ask(8).expect("a job");
    pool.open(1, 7);
    // It dies under the one; then it waits for the other, busy as that is.
    let grant = pool.ask(9).expect("the job");
    crash(&mut pool, 9, grant);
    pool.pass(300);
    assert_eq!(pool.ask(9), None);
    pool.done(8, other);
    let grant = pool.ask(8).expect("the job again");
    crash(&mut pool, 8, grant);
    // It has died under both, and one of them waits.
    let said = pool.pass(300);
    let grant = granted(&said, Worker(9)).expect("the job for the last time");
    let told = crash(&mut pool, 9, grant);
    let reason = Reason::Crashes { deaths: 3, workers: 2 };
    let stall = Effect::Stall { job: job(7), reason, attempts: 3 };
    assert!(matches!(told[..2], [Effect::Lost { .. }, Effect::Quarantine { crashes: 3, .. }]));
    assert!(told.contains(&stall), "{told:?}");
    let said = pool.open(2, 7);
    assert!(matches!(said[..], [Effect::Stall { .. }, Effect::Settle { run: Run(2), .. }]));
    pool.step(Event::Pardon(job(7)));
    pool.open(2, 7);
    assert!(pool.ask(8).is_some());
}

/// However the busy one goes, the job goes to who is there.
#[test]
fn a_job_waits_for_a_busy_worker_rather_than_go_where_it_died_and_holds_nobody_up() {
    let leaves = [Event::Down(Worker(1)), Event::Bye(Worker(1)), Event::Drain(Worker(1))];
    for leave in leaves.into_iter().map(Some).chain([None]) {
        let mut pool = Pool::new();
        pool.begin(1, 1, 4);
        pool.open(1, 1);
        let long = pool.ask(1).expect("a job");
        pool.open(1, 2);
        let spoilt = pool.ask(2).expect("another");
        crash(&mut pool, 2, spoilt);
        pool.pass(300);
        pool.open(1, 3);
        // Others of its run pass it.
        let third = pool.ask(2).expect("the one behind it");
        assert_eq!(third.0, job(3));
        pool.done(2, third);
        assert_eq!(pool.ask(2), None, "it waits for the other");
        let said = match leave {
            Some(event) => pool.step(event),
            None => {
                pool.done(1, long);
                assert_eq!(pool.ask(1).map(|(job, _)| job), Some(job(2)));
                continue;
            }
        };
        assert_eq!(granted(&said, Worker(2)).map(|(job, _)| job), Some(job(2)), "{leave:?}");
    }
}

/// One that ended unnoticed is not waited for.
#[test]
fn a_job_does_not_wait_for_a_worker_that_has_not_been_heard_of() {
    let mut pool = Pool::new();
    pool.begin(1, 1, 4);
    pool.open(1, 1);
    let last = pool.ask(1).expect("a job");
    pool.done(1, last);
    pool.open(1, 2);
    let spoilt = pool.ask(2).expect("a job");
    crash(&mut pool, 2, spoilt);
    let patience = Timing::test().park + Timing::test().lease;
    pool.pass(300);
    assert_eq!(pool.ask(2), None, "the other may ask again");
    let mut said = Vec::new();
    for _ in 0..20 {
        said.extend(pool.pass(patience / 10));
        pool.seq += 1;
        let seq = pool.seq;
        said.extend(pool.step(poll(Worker(2), seq, Skills::ALL)));
    }
    assert!(granted(&said, Worker(2)).is_some(), "{said:?}");
}

#[test]
fn a_worker_under_which_jobs_die_alone_is_drained_unless_they_die_elsewhere_or_it_is_the_last() {
    // What another can that is there and busy; whether others try the jobs, and they die there too.
    let (all, less) = (Some(Skills::ALL), Some(Skills::NONE));
    for (busy, poison, want) in
        [(all, false, true), (all, true, false), (None, true, false), (less, false, false)]
    {
        let mut pool = Pool::new();
        pool.begin(1, 1, 4);
        let long = busy.and_then(|skills| {
            pool.open(1, 100);
            granted(&pool.step(poll(Worker(1), 1, skills)), Worker(1))
        });
        assert_eq!(long.is_some(), busy.is_some());
        let mut drained = Vec::new();
        for k in 0..30 {
            pool.open(1, k);
            for worker in if poison { 2..=3 } else { 2..=2 } {
                pool.seq += 1;
                let seq = pool.seq;
                let said = pool.step(poll(Worker(worker), seq, Skills::ALL));
                drained.extend(said.iter().filter_map(|effect| match effect {
                    Effect::Drained { worker, cause } => Some((worker.0, *cause)),
                    _ => None,
                }));
                if let Some(grant) = granted(&said, Worker(worker)) {
                    crash(&mut pool, worker, grant);
                }
                pool.pass(100);
                long.into_iter().for_each(|grant| pool.renew(1, grant));
            }
        }
        let want: &[_] = if want { &[(2, Cause::Alone)] } else { &[] };
        assert_eq!(drained, want, "busy {busy:?}, poison {poison}");
    }
}

#[test]
fn a_worker_that_vanishes_is_charged_to_the_job_that_its_solver_has_and_to_no_other() {
    // How far three workers are as they vanish; whether the job is given up.
    for (begun, offered, guilty) in
        [(false, false, false), (true, false, true), (true, true, false), (false, true, false)]
    {
        let mut pool = Pool::new();
        pool.begin(1, 1, 4);
        pool.open(1, 1);
        let mut told = Vec::new();
        for worker in 1..=3 {
            let (job, epoch) = pool.ask(worker).unwrap_or_else(|| {
                panic!("no job for worker {worker}");
            });
            if offered {
                pool.step(Event::Offer { job, epoch });
            }
            // Late, or not: it takes nothing back.
            pool.step(renewal(worker, (job, epoch), begun));
            told = pool.step(Event::Down(Worker(worker)));
            let charged = told.iter().find_map(|effect| match effect {
                Effect::Lost { charged, .. } => Some(*charged),
                _ => None,
            });
            assert_eq!(charged, Some(guilty), "begun: {begun}, offered: {offered}");
            pool.pass(2_000);
        }
        let given_up = told.iter().any(|effect| matches!(effect, Effect::Quarantine { .. }));
        assert_eq!(given_up, guilty, "begun: {begun}, offered: {offered}: {told:?}");
    }
}

/// Two processes of one name, and one of another. What dies under the two died under one name: the
/// job waits for the other, who does it, and the name is told apart by what it is, not by how often
/// it came.
#[test]
fn many_processes_of_one_name_count_as_one() {
    let mut pool = Pool::new();
    pool.begin(1, 1, 4);
    let evil = |pool: &mut Pool, worker: u64| pool.ask_as(1, worker);
    // The other is there, and has its own to do.
    pool.open(1, 100);
    let mut long = pool.ask(9).expect("a job");
    for k in 0..3 {
        pool.open(1, k);
        let first = evil(&mut pool, 10 + 2 * k).expect("a job");
        assert_eq!(first.0, job(k));
        crash(&mut pool, 10 + 2 * k, first);
        pool.pass(300);
        assert_eq!(evil(&mut pool, 11 + 2 * k), None, "it has died under that name");
        for worker in [10 + 2 * k, 11 + 2 * k] {
            pool.step(Event::Bye(Worker(worker)));
        }
        pool.done(9, long);
        long = pool.ask(9).expect("the job goes to who did not kill it");
        assert_eq!(long.0, job(k));
        pool.done(9, long);
        pool.open(1, 101 + k);
        long = pool.ask(9).expect("a job");
    }
    // However it comes back.
    pool.open(1, 200);
    assert_eq!(evil(&mut pool, 20), None);
    let sent_away = |said: &[Effect]| said.iter().any(|it| matches!(it, Effect::Dismiss { .. }));
    pool.seq += 1;
    let seq = pool.seq;
    assert!(sent_away(&pool.step(poll_as(1, Worker(20), seq))));
    // A while after it went the name is as good as any.
    for (worker, wait) in [(20, 10_000), (21, 60_000)] {
        pool.step(Event::Bye(Worker(worker)));
        pool.pass(wait);
        // What the other had lapsed, and waits a little.
        pool.pass(1_000);
        assert!(pool.ask(9).is_some(), "the other is there");
        assert_eq!(evil(&mut pool, worker + 1).is_some(), wait == 60_000, "after {wait} ms");
    }
}

/// Whatever its number, and whoever came and went since it was last heard of.
#[test]
fn a_process_that_was_forgotten_has_the_name_that_it_asks_under() {
    for forgotten in [10, u64::MAX] {
        let mut pool = Pool::new();
        pool.begin(1, 1, 4);
        pool.open(1, 100);
        let _long = pool.ask(9).expect("the other is there, and has its own to do");
        pool.open(1, 1);
        let bad = pool.ask_as(1, forgotten).expect("a job");
        crash(&mut pool, forgotten, bad);
        pool.step(Event::Bye(Worker(forgotten)));
        assert_eq!(pool.ask_as(1, 11), None, "it has died under that name");
        for other in 0..4_097 {
            pool.ask_as(2, 1_000 + other);
            pool.step(Event::Bye(Worker(1_000 + other)));
        }
        pool.pass(300);
        assert_eq!(pool.ask_as(1, forgotten), None, "{forgotten}");
    }
}

/// As often as a name is blamed, those of it that are gone are left alone until they come back.
#[test]
fn blame_sends_away_who_is_there_and_who_comes_back() {
    let mut pool = Pool::new();
    pool.begin(1, 1, 4);
    for worker in 100..200 {
        pool.ask_as(1, worker);
        pool.step(Event::Bye(Worker(worker)));
    }
    assert_eq!(pool.ask_as(1, 11), None);
    let mut drained = Vec::new();
    for k in 0..3 {
        pool.open(1, k);
        let bad = if k == 0 { granted_now(&mut pool, 11) } else { pool.ask_as(1, 11) };
        crash(&mut pool, 11, bad.expect("a job"));
        pool.pass(300);
        let good = pool.ask(9).expect("the job again");
        drained = pool.done(9, good);
        drained.retain(|effect| matches!(effect, Effect::Drained { .. }));
    }
    assert_eq!(drained, [Effect::Drained { worker: Worker(11), cause: Cause::Blamed }]);
    pool.seq += 1;
    let seq = pool.seq;
    let said = pool.step(poll_as(1, Worker(150), seq));
    let away = Effect::Drained { worker: Worker(150), cause: Cause::Blamed };
    assert_eq!(said, [away, Effect::Dismiss { worker: Worker(150), seq }]);
    // What the pool found by itself is asked for as anything else.
    let asked = Effect::Drained { worker: Worker(11), cause: Cause::Asked };
    assert_eq!(pool.step(Event::Drain(Worker(11))), [asked]);
}

/// What a worker whose question was parked was granted by an event before.
fn granted_now(pool: &mut Pool, worker: u64) -> Option<(Job, Epoch)> {
    let seq = pool.seq;
    granted(&pool.step(poll_as(1, Worker(worker), seq)), Worker(worker))
}

#[test]
fn what_dies_under_a_name_alone_is_held_against_it_for_a_minute_from_the_last() {
    for (wait, cleared) in [(30_000, false), (60_000, true)] {
        let mut pool = Pool::new();
        pool.begin(1, 1, 4);
        pool.now = 100_000;
        // The other is there, and never has the time.
        let busy = |pool: &mut Pool| {
            pool.seq += 1;
            let mut event = poll(Worker(9), pool.seq, Skills::ALL);
            if let Event::Poll { slots, .. } = &mut event {
                *slots = 0;
            }
            pool.step(event);
        };
        busy(&mut pool);
        for k in 0..3 {
            pool.open(1, k);
            let bad = pool.ask_as(1, 10).expect("a job");
            crash(&mut pool, 10, bad);
        }
        pool.step(Event::Bye(Worker(10)));
        for _ in 0..wait / 500 {
            pool.pass(500);
            busy(&mut pool);
        }
        pool.seq += 1;
        let seq = pool.seq;
        let said = pool.step(poll_as(1, Worker(11), seq));
        let away = Effect::Drained { worker: Worker(11), cause: Cause::Alone };
        assert_eq!(!said.contains(&away), cleared, "after {wait} ms: {said:?}");
    }
}

#[test]
fn the_duplicate_of_a_slow_job_goes_to_another_name() {
    let mut pool = Pool::new();
    pool.begin(1, 1, 4);
    for k in 0..8 {
        pool.open(1, k);
        let quick = pool.ask(9).expect("a job");
        pool.pass(100);
        pool.done(9, quick);
    }
    pool.open(1, 100);
    let slow = pool.ask_as(1, 10).expect("a job");
    let wait = |pool: &mut Pool, worker: u64, name: u64| {
        let mut got = None;
        for _ in 0..10 {
            got = got.or(pool.ask_as(name, worker));
            pool.renew(10, slow);
            got = got.or(granted(&pool.pass(500), Worker(worker)));
        }
        got.map(|(job, _)| job)
    };
    assert_eq!(wait(&mut pool, 11, 1), None, "it has the job already, by that name");
    assert_eq!(wait(&mut pool, 12, 2), Some(slow.0));
}

#[test]
fn the_last_name_that_can_do_something_stays_whatever_number_of_processes_has_it() {
    let mut pool = Pool::new();
    pool.begin(1, 1, 4);
    pool.open(1, 100);
    let _long = pool.ask_as(1, 2).expect("a job");
    for k in 0..8 {
        pool.open(1, k);
        let bad = pool.ask_as(1, 1).expect("there is no other name to wait for");
        let said = crash(&mut pool, 1, bad);
        assert!(!said.iter().any(|it| matches!(it, Effect::Drained { .. })), "{said:?}");
        pool.pass(Timing::test().lease);
    }
}

/// One that says it can do everything is the last that can, and is not sent away: it gets what
/// nobody else can do.
#[test]
fn a_doubted_name_gets_only_what_nobody_else_can_do() {
    let mut pool = Pool::new();
    pool.begin(1, 1, 4);
    let plain = |pool: &mut Pool| {
        pool.seq += 1;
        let said = pool.step(poll(Worker(9), pool.seq, Skills(1)));
        granted(&said, Worker(9))
    };
    for k in 0..3 {
        pool.open(1, k);
        let bad = pool.ask_as(1, 11).expect("a job");
        crash(&mut pool, 11, bad);
        pool.pass(300);
        let good = plain(&mut pool).expect("the job again");
        let said = pool.done(9, good);
        assert!(!said.iter().any(|it| matches!(it, Effect::Drained { .. })), "{said:?}");
    }
    pool.open(1, 10);
    let busy = plain(&mut pool).expect("a job");
    pool.open(1, 11);
    // Not even while the other is busy, and not under another of its sessions.
    assert_eq!((pool.ask_as(1, 11), pool.ask_as(1, 12)), (None, None));
    let said = pool.done(9, busy);
    assert!(!said.iter().any(|it| matches!(it, Effect::Grant { .. })), "{said:?}");
    assert_eq!(plain(&mut pool).map(|(got, _)| got), Some(job(11)));
    let rare = Event::Open {
        run: Run(1),
        job: job(12),
        need: Skills(2),
        after: None,
        prior: Prior::Nothing,
    };
    let said = pool.step(rare);
    assert!(granted(&said, Worker(11)).is_some(), "nobody else can do it: {said:?}");
}
