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
