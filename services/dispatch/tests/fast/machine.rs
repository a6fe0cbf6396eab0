//! What the machine decides in plain situations, one by one; faults are the simulation's.

use crate::common;

use common::*;
use cullet_dispatch::*;
use std::collections::BTreeMap;

/// One worker that takes 100 ms a job: how many of so many grants each run gets.
fn shared(pool: &mut Pool, grants: u64, owner: impl Fn(Job) -> u64) -> BTreeMap<u64, u64> {
    let mut counts = BTreeMap::new();
    for _ in 0..grants {
        let grant = pool.ask(1).expect("a job");
        *counts.entry(owner(grant.0)).or_default() += 1;
        pool.now += 100;
        pool.done(1, grant);
    }
    counts
}

fn of(run: u64, k: u64) -> u64 {
    run << 16 | k
}

fn run_of(job: Job) -> u64 {
    let bytes: [u8; 8] = job.0[..8].try_into().unwrap_or_default();
    u64::from_be_bytes(bytes) >> 16
}

#[test]
fn a_step_of_priority_doubles_a_share_and_tenants_share_evenly() {
    let mut pool = Pool::new();
    // A tenant with two runs, one of which counts twice; a tenant with one run.
    for (run, tenant, priority) in [(1, 1, 4), (2, 1, 5), (3, 2, 4)] {
        pool.begin(run, tenant, priority);
        for k in 0..400 {
            pool.open(run, of(run, k));
        }
    }
    let counts = shared(&mut pool, 300, run_of);
    for (run, due) in [(1, 50), (2, 100), (3, 150)] {
        let got = counts[&run];
        assert!(got.abs_diff(due) <= 4, "run {run} got {got} of 300, {due} were due");
    }
}

#[test]
fn idleness_saves_nothing_up_and_no_priority_starves_another() {
    let mut pool = Pool::new();
    pool.begin(1, 1, 4);
    pool.begin(2, 1, 4);
    for k in 0..300 {
        pool.open(1, of(1, k));
    }
    shared(&mut pool, 100, run_of);
    for k in 0..300 {
        pool.open(2, of(2, k));
    }
    let counts = shared(&mut pool, 100, run_of);
    assert!(counts[&1].abs_diff(50) <= 3, "{counts:?}");
    // 512 times the weight: by shares alone the other would wait for 51 s.
    let mut pool = Pool::new();
    pool.begin(1, 1, 9);
    pool.begin(2, 1, 0);
    for k in 0..400 {
        pool.open(1, of(1, k));
        pool.open(2, of(2, k));
    }
    let counts = shared(&mut pool, 300, run_of);
    let waits = 300 * 100 / Timing::test().age;
    assert!(counts[&2] >= waits, "{counts:?} in 30 s, each wait at most 6 s");
    assert!(counts[&2] <= waits + 3, "{counts:?}: ageing is the exception");
}

#[test]
fn a_straggler_gets_one_duplicate_and_the_first_result_counts() {
    let mut pool = Pool::new();
    pool.begin(1, 1, 4);
    for k in 0..4 {
        pool.open(1, k);
    }
    for _ in 0..3 {
        let grant = pool.ask(1).expect("a job");
        pool.now += 100;
        pool.done(1, grant);
    }
    let slow = pool.ask(1).expect("the last");
    assert_eq!((pool.ask(2), pool.ask(3)), (None, None));
    let mut doubled = Vec::new();
    for _ in 0..40 {
        pool.now += 100;
        pool.renew(1, slow);
        let said = pool.step(Event::Tick);
        doubled.extend([2, 3].into_iter().filter_map(|w| granted(&said, Worker(w))));
        doubled.iter().for_each(|grant| pool.renew(2, *grant));
    }
    assert_eq!(doubled.len(), 1, "one duplicate, not more");
    let said = pool.done(2, doubled[0]);
    assert!(said.iter().any(|e| matches!(e, Effect::Settle { opening: 3, .. })));
    let (job, epoch) = slow;
    let said = pool.step(renewal(1, (job, epoch), true));
    assert!(matches!(said[..], [Effect::Stop { .. }]));
    assert_eq!(pool.machine.counts().hedged, 1);
}

#[test]
fn a_late_result_counts_while_the_job_is_open_and_is_compared_after() {
    let mut pool = Pool::new();
    pool.begin(1, 1, 4);
    pool.open(1, 1);
    let late = pool.ask(1).expect("a job");
    pool.pass(2_000);
    pool.pass(100);
    let again = pool.ask(2).expect("the job again");
    assert!(again.1 > late.1);
    let said = pool.done(1, late);
    let accepted = |e: &Effect| matches!(e, Effect::Taken { receipt: Receipt::Accepted, .. });
    assert!(said.iter().any(accepted));
    let same = pool.done(2, again);
    assert!(matches!(same[..], [Effect::Taken { receipt: Receipt::Duplicate, .. }]));
    let (worker, outcome, digest) = (Worker(2), Outcome::Broken, Digest([9; 32]));
    let (job, epoch) = again;
    let (name, build, prior) = (WorkerName(2), BUILD, Prior::Nothing);
    let late =
        |job, prior| Event::Commit { worker, name, job, epoch, build, digest, outcome, prior };
    let other = pool.step(late(job, prior));
    assert!(matches!(other[0], Effect::Alarm { .. }));
    let stranger = Job([5; 32]);
    let said = pool.step(late(stranger, prior));
    assert!(matches!(said[..], [Effect::Taken { receipt: Receipt::Unknown, .. }]));
}

#[test]
fn a_late_result_of_another_build_is_fenced_and_raises_no_alarm() {
    let mut pool = Pool::new();
    pool.begin(1, 1, 4);
    pool.open(1, 1);
    let (job, late) = pool.ask(1).expect("a job");
    let by = |build: u8, digest: u8, epoch| Event::Commit {
        worker: Worker(1),
        name: WorkerName(1),
        job,
        epoch,
        build: Build([build; 32]),
        digest: Digest([digest; 32]),
        outcome: Outcome::Broken,
        prior: Prior::Nothing,
    };
    pool.pass(2_000);
    pool.pass(100);
    let (_, now) = pool.ask(2).expect("the job again");
    assert!(!pool.machine.takes(job, late, Build([2; 32])));
    let said = pool.step(by(2, 9, late));
    assert!(matches!(said[..], [Effect::Taken { receipt: Receipt::Fenced, .. }]), "{said:?}");
    // By the grant that stands it counts, whatever made it.
    let said = pool.step(by(3, 8, now));
    assert!(said.iter().any(|e| matches!(e, Effect::Settle { .. })));
    let said = pool.step(by(2, 9, late));
    assert!(matches!(said[..], [Effect::Taken { receipt: Receipt::Fenced, .. }]), "{said:?}");
    let said = pool.step(by(3, 9, late));
    assert!(matches!(said[0], Effect::Alarm { .. }), "{said:?}");
    assert_eq!((pool.machine.counts().fenced, pool.machine.counts().alarms), (2, 1));
}

/// As much as of one that was found in this life, whether the job is opened again or not.
#[test]
fn a_late_result_that_differs_from_one_that_was_kept_raises_an_alarm() {
    let result = |build: Option<u8>| Prior::Result {
        digest: Digest([8; 32]),
        outcome: Outcome::Broken,
        build: build.map(|build| Build([build; 32])),
    };
    for opened in [false, true] {
        // What was kept, and what comes late: of which build, and which digest; what is said.
        for (kept, (build, digest), want) in [
            (Some(1), (1, 9), Receipt::Conflict),
            (Some(1), (1, 8), Receipt::Duplicate),
            (Some(1), (2, 9), Receipt::Fenced),
            (None, (1, 9), Receipt::Fenced),
        ] {
            let mut pool = Pool::new();
            pool.begin(1, 1, 4);
            let (job, need, prior) = (job(1), Skills::NONE, result(kept));
            if opened {
                pool.step(Event::Open { run: Run(1), job, need, after: None, prior });
            }
            assert_eq!(pool.machine.knows(job), opened);
            let said = pool.step(Event::Commit {
                worker: Worker(1),
                name: WorkerName(1),
                job,
                epoch: Epoch(7),
                build: Build([build; 32]),
                digest: Digest([digest; 32]),
                outcome: Outcome::Broken,
                prior: if opened { Prior::Nothing } else { prior },
            });
            let alarm = matches!(said[0], Effect::Alarm { .. });
            assert_eq!(alarm, want == Receipt::Conflict, "{said:?}");
            let receipt = Effect::Taken { worker: Worker(1), receipt: want };
            assert!(said.contains(&receipt), "opened {opened}: {said:?}");
        }
    }
}

#[test]
fn who_has_a_job_that_nobody_wants_any_more_is_told_at_once() {
    let told = |said: &[Effect]| {
        let cancel = |effect: &Effect| match effect {
            Effect::Cancel { worker, epoch, .. } => Some((worker.0, *epoch)),
            _ => None,
        };
        said.iter().filter_map(cancel).collect::<Vec<_>>()
    };
    let mut pool = Pool::new();
    pool.begin(1, 1, 4);
    pool.begin(2, 1, 4);
    pool.open(1, 1);
    pool.open(2, 1);
    pool.open(1, 2);
    let (common, own) = (pool.ask(1).expect("a job"), pool.ask(2).expect("another"));
    let watch_cancel =
        |worker, (job, epoch)| Event::WatchCancel { worker: Worker(worker), job, epoch };
    for (worker, grant) in [(1, common), (2, own)] {
        assert_eq!(told(&pool.step(watch_cancel(worker, grant))), []);
    }
    // Another run wants the first still.
    assert_eq!(told(&pool.step(Event::Cancel(Run(1)))), [(2, own.1)]);
    assert_eq!(
        told(&pool.step(watch_cancel(2, own))),
        [(2, own.1)],
        "asked again, it is told again"
    );
    assert_eq!(told(&pool.step(watch_cancel(1, common))), []);
    // Its lease runs out, another has it, and is overtaken by the first.
    pool.pass(2_000);
    pool.pass(100);
    assert_eq!(told(&pool.step(watch_cancel(1, common))), [], "a renewal takes it up again");
    let again = pool.ask(2).expect("the job again");
    assert_eq!(told(&pool.step(watch_cancel(1, common))), [(1, common.1)]);
    assert_eq!(told(&pool.done(1, common)), [(2, again.1)]);
    // Who hands in what counts knows that; and of another life nothing is known.
    pool.open(1, 3);
    let last = pool.ask(1).expect("a job");
    assert_eq!(told(&pool.done(1, last)), []);
    assert_eq!(told(&pool.step(watch_cancel(1, (job(9), Epoch(3))))), []);
}

#[test]
fn a_job_waits_for_a_worker_that_can_do_it_and_others_pass_it() {
    let mut pool = Pool::new();
    pool.begin(1, 1, 9);
    pool.begin(2, 1, 0);
    let (need, prior) = (Skills(0b10), Prior::Nothing);
    pool.step(Event::Open { run: Run(1), job: job(1), need, after: None, prior });
    assert_eq!(pool.machine.counts().unschedulable, 0, "nobody is there");
    pool.open(2, 2);
    let said = pool.step(poll(Worker(1), 1, Skills(0b01)));
    assert_eq!(granted(&said, Worker(1)).map(|(job, _)| job), Some(job(2)));
    assert_eq!(pool.machine.unschedulable().collect::<Vec<_>>(), [(Skills(0b10), 1)]);
    let both = Skills(0b11);
    let said = pool.step(poll(Worker(2), 1, both));
    assert_eq!(granted(&said, Worker(2)).map(|(job, _)| job), Some(job(1)));
    assert_eq!(pool.machine.counts().unschedulable, 0);
    // The last who can goes: what waits then waits aloud.
    pool.step(Event::Down(Worker(2)));
    pool.pass(300);
    assert_eq!(pool.machine.counts().unschedulable, 1);
    pool.step(Event::Cancel(Run(1)));
    assert_eq!(pool.machine.counts().unschedulable, 0);
}

/// Whichever way they are kept: by when their time was, and where it was the same, by name.
#[test]
fn what_runs_out_in_one_tick_is_looked_at_in_order_of_time_and_name() {
    for names in [[1, 2, 3, 4, 5, 6], [6, 5, 4, 3, 2, 1], [3, 6, 1, 5, 2, 4]] {
        let mut pool = Pool::new();
        pool.begin(1, 1, 4);
        // Two at a time, 7 ms apart: within a slot of the timers and across two of them.
        let mut want = Vec::new();
        for (turn, pair) in names.chunks(2).enumerate() {
            for name in pair {
                pool.open(1, *name);
                pool.ask(*name).expect("a job");
            }
            let mut pair = pair.to_vec();
            pair.sort_unstable();
            want.extend(pair);
            pool.now = 7 * (turn as Millis + 1);
        }
        let said = pool.pass(Timing::test().lease);
        let lost = said.iter().filter_map(|effect| match effect {
            Effect::Lost { job, .. } => Some(*job),
            _ => None,
        });
        let want: Vec<Job> = want.into_iter().map(job).collect();
        assert_eq!(lost.collect::<Vec<_>>(), want, "opened as {names:?}");
    }
}

/// Of a machine in its second life.
fn second_life(inherited: &[u64]) -> Pool {
    let mut pool = Pool { machine: Dispatch::new(Timing::test(), 2), now: 0, seq: 0 };
    inherited.iter().for_each(|k| drop(pool.step(Event::Inherit(job(*k), Claimant(1)))));
    pool.begin(1, 1, 4);
    pool
}

#[test]
fn what_an_earlier_life_has_granted_goes_on_and_waits_for_its_worker_for_a_lease() {
    let mut pool = second_life(&[1, 2, 3]);
    let before = |k| (job(k), Epoch(1 << 32 | k));
    // WorkerInput of before a run has opened it.
    assert!(matches!(pool.step(renewal(11, before(1), true))[..], [Effect::Renewed { .. }]));
    let said = pool.open(1, 1);
    assert!(matches!(said[..], [Effect::Adopted { worker: Worker(11), .. }]), "{said:?}");
    // Handed in before a run has opened it.
    let said = pool.done(12, before(2));
    assert!(matches!(said[..], [Effect::Taken { receipt: Receipt::Accepted, .. }]), "{said:?}");
    // Not heard of.
    pool.open(1, 3);
    assert!(pool.ask(4).is_none() && pool.pass(1_400).is_empty());
    pool.renew(11, before(1));
    assert_eq!(granted(&pool.pass(200), Worker(4)).map(|(what, _)| what), Some(job(3)));
    assert_eq!((pool.machine.counts().adopted, pool.machine.counts().resent), (1, 0));
    // What nobody has inherited is not known.
    assert!(matches!(pool.step(renewal(13, before(4), true))[..], [Effect::Stop { .. }]));
}

#[test]
fn who_is_at_what_an_earlier_life_has_granted_is_told_when_the_runs_that_wanted_it_are_over() {
    let mut pool = second_life(&[1, 2, 3]);
    pool.step(Event::Inherit(job(3), Claimant(2)));
    assert_eq!(
        pool.machine.claimants().into_iter().collect::<Vec<_>>(),
        [Claimant(1), Claimant(2)]
    );
    let before = |k| (job(k), Epoch(1 << 32 | k));
    pool.renew(11, before(1));
    pool.renew(13, before(3));
    // Who was heard is told at once, and who was not hears it when it speaks.
    let said = pool.step(Event::Release(Claimant(1)));
    let told = Effect::Cancel { worker: Worker(11), job: job(1), epoch: before(1).1 };
    assert_eq!(said, [told]);
    let told = Effect::Cancel { worker: Worker(12), job: job(2), epoch: before(2).1 };
    let watch = Event::WatchCancel { worker: Worker(12), job: job(2), epoch: before(2).1 };
    assert_eq!(pool.step(watch), [told]);
    for (worker, k) in [(11, 1), (12, 2)] {
        assert!(matches!(pool.step(renewal(worker, before(k), true))[..], [Effect::Stop { .. }]));
        let said = pool.done(worker, before(k));
        assert!(matches!(said[..], [Effect::Taken { receipt: Receipt::TooLate, .. }]), "{said:?}");
    }
    // Another run wants the third.
    assert!(matches!(pool.step(renewal(13, before(3), true))[..], [Effect::Renewed { .. }]));
    // Wanted again, a job waits for nobody.
    pool.open(1, 1);
    assert_eq!(pool.ask(4).map(|(what, _)| what), Some(job(1)));
    let said = pool.open(1, 3);
    assert!(matches!(said[..], [Effect::Adopted { worker: Worker(13), .. }]), "{said:?}");
}

/// A worker that says it is at what another is heard to be at gets nothing by that.
#[test]
fn nobody_gives_back_or_takes_over_what_another_is_heard_to_be_at() {
    let fail = |worker, (job, epoch)| Event::Fail {
        worker: Worker(worker),
        job,
        epoch,
        trouble: Trouble::Crashed,
    };
    let own = (job(1), Epoch(1 << 32 | 1));
    let said = (job(1), Epoch(0));
    let mut pool = second_life(&[1]);
    pool.renew(11, own);
    pool.step(fail(66, said));
    pool.pass(100);
    pool.renew(66, said);
    let opened = pool.open(1, 1);
    assert!(matches!(opened[..], [Effect::Adopted { worker: Worker(11), .. }]), "{opened:?}");
    // Nor once a run has opened it, however often that changes.
    pool.step(Event::Inherit(job(1), Claimant(2)));
    pool.step(fail(66, said));
    pool.step(Event::Cancel(Run(1)));
    assert!(pool.machine.is_inherited(job(1)));
    // One that is not heard any more is nobody's.
    pool.pass(Timing::test().lease);
    pool.renew(66, said);
    pool.begin(2, 1, 4);
    let opened = pool.open(2, 1);
    assert!(matches!(opened[..], [Effect::Adopted { worker: Worker(66), .. }]), "{opened:?}");
}

#[test]
fn a_run_that_wants_an_orphan_no_more_leaves_it_to_the_next_heir() {
    let mut pool = second_life(&[1, 2, 3, 4]);
    for k in [1, 2, 4] {
        pool.step(Event::Inherit(job(k), Claimant(2)));
    }
    let before = |k| (job(k), Epoch(1 << 32 | k));
    // The workers of the first and the third are heard, the second goes to somebody else, and the
    // fourth is waited for.
    for k in 1..=4 {
        pool.open(1, k);
    }
    let hear = |pool: &mut Pool| [1, 3].into_iter().for_each(|k| pool.renew(10 + k, before(k)));
    hear(&mut pool);
    pool.pass(1_400);
    hear(&mut pool);
    pool.pass(200);
    let second = pool.ask(5).expect("nobody is waited for any more");
    assert_eq!(second.0, job(2));
    let said = pool.step(Event::Cancel(Run(1)));
    let told: Vec<_> = said.iter().filter(|e| matches!(e, Effect::Cancel { .. })).collect();
    assert_eq!(told, [&Effect::Cancel { worker: Worker(5), job: job(2), epoch: second.1 }]);
    let said = pool.step(Event::Release(Claimant(1)));
    let told = Effect::Cancel { worker: Worker(13), job: job(3), epoch: before(3).1 };
    assert_eq!(said, [told], "nobody else will want the third");
    assert_eq!([1, 2, 3, 4].map(|k| pool.machine.is_inherited(job(k))), [true, false, false, true]);
    for (worker, k) in [(11, 1), (14, 4)] {
        let said = pool.step(renewal(worker, before(k), true));
        assert!(matches!(said[..], [Effect::Renewed { .. }]), "{said:?}");
    }
    pool.begin(2, 1, 4);
    let said = pool.open(2, 1);
    assert!(matches!(said[..], [Effect::Adopted { worker: Worker(11), .. }]), "{said:?}");
    let said = pool.step(Event::Cancel(Run(2)));
    assert!(said.iter().all(|effect| !matches!(effect, Effect::Cancel { .. })), "{said:?}");
    let told = Effect::Cancel { worker: Worker(11), job: job(1), epoch: before(1).1 };
    let said = pool.step(Event::Release(Claimant(2)));
    assert!(said.contains(&told) && said.len() == 2, "{said:?}");
    assert!(pool.machine.claimants().is_empty());
}
