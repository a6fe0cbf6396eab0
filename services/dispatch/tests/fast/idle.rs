//! A worker that leaves once it has had no job for long enough.

use cullet_dispatch::*;

/// How long the worker of these tests waits without a job \[ms\].
const LIMIT: Millis = 1_000;

fn work(epoch: u64) -> Work {
    Work { job: Job([7; 32]), epoch: Epoch(epoch), renew: 300, hard: 20_000 }
}

fn asks(question: Question) -> WorkerOutput {
    WorkerOutput::Ask(question)
}

/// One that has begun at 0 ms and asks for work.
fn begun() -> WorkerMachine {
    let mut worker = WorkerMachine::leaving_when_idle(LIMIT);
    assert_eq!(worker.step(0, WorkerInput::Begin), [asks(Question::Poll { seq: 1 })]);
    worker
}

/// Lets it have a job, which it hands in; the question for the next one.
fn does_a_job(worker: &mut WorkerMachine, seq: u64, from: Millis, to: Millis) -> Question {
    let (work, epoch) = (work(seq), Epoch(seq));
    assert_eq!(
        worker.step(from, WorkerInput::Grant { seq, work }),
        [WorkerOutput::Fetch(work)],
        "it takes the job"
    );
    worker.step(from, WorkerInput::Fetched { epoch });
    worker.step(to, WorkerInput::Solved { epoch, digest: Digest([1; 32]) });
    let out = worker.step(to, WorkerInput::Receipt { epoch, next: None });
    let [WorkerOutput::Ask(question @ Question::Poll { .. })] = out[..] else { panic!("{out:?}") };
    question
}

#[test]
fn it_leaves_when_it_has_had_no_job_for_that_long_and_not_before() {
    let mut worker = begun();
    assert_eq!(worker.wake(), Some(LIMIT));
    // Answers that there is none, and silence, are no jobs.
    assert_eq!(
        worker.step(400, WorkerInput::Idle { seq: 1 }),
        [asks(Question::Poll { seq: 2 })],
        "it asks again"
    );
    worker.step(500, WorkerInput::Silence(Question::Poll { seq: 2 }));
    assert_eq!(worker.step(LIMIT - 1, WorkerInput::Tick), [asks(Question::Poll { seq: 2 })]);
    assert_eq!(worker.step(LIMIT, WorkerInput::Tick), [asks(Question::Bye)]);
    assert_eq!(worker.step(LIMIT + 5, WorkerInput::Noted), [WorkerOutput::Leave]);
    assert!(worker.left());
}

#[test]
fn a_job_starts_the_time_anew_however_it_ends() {
    let mut worker = begun();
    let question = does_a_job(&mut worker, 1, 900, 5_000);
    assert_eq!(worker.wake(), Some(5_000 + LIMIT));
    let Question::Poll { seq } = question else { panic!("{question:?}") };
    // One that is not wanted any more, and one that is given back.
    worker.step(5_900, WorkerInput::Grant { seq, work: work(2) });
    worker.step(6_500, WorkerInput::Stop { epoch: Epoch(2) });
    assert_eq!(worker.wake(), Some(6_500 + LIMIT));
    worker.step(7_400, WorkerInput::Grant { seq: seq + 1, work: work(3) });
    worker.step(7_450, WorkerInput::Trouble { epoch: Epoch(3), trouble: Trouble::Dropped });
    worker.step(7_500, WorkerInput::Noted);
    assert_eq!(worker.step(7_500 + LIMIT - 1, WorkerInput::Tick), []);
    assert_eq!(worker.step(7_500 + LIMIT, WorkerInput::Tick), [asks(Question::Bye)]);
}

#[test]
fn it_never_leaves_with_a_job_or_a_result_at_hand() {
    let mut worker = begun();
    let epoch = Epoch(1);
    worker.step(10, WorkerInput::Grant { seq: 1, work: work(1) });
    let is_bye = |out: &[WorkerOutput]| out.contains(&asks(Question::Bye));
    assert!(!is_bye(&worker.step(3 * LIMIT, WorkerInput::Tick)), "while it fetches");
    worker.step(3 * LIMIT, WorkerInput::Fetched { epoch });
    assert!(!is_bye(&worker.step(6 * LIMIT, WorkerInput::Tick)), "while it solves");
    let solved = WorkerInput::Solved { epoch, digest: Digest([1; 32]) };
    let out = worker.step(6 * LIMIT, solved);
    let [WorkerOutput::Ask(commit)] = out[..] else { panic!("{out:?}") };
    worker.step(6 * LIMIT, WorkerInput::Silence(commit));
    assert!(!is_bye(&worker.step(60 * LIMIT, WorkerInput::Tick)), "while nobody takes the result");
    assert!(worker.at().is_some());
}

#[test]
fn it_ends_without_a_coordinator_and_stays_without_a_limit() {
    let mut worker = begun();
    worker.step(LIMIT, WorkerInput::Tick);
    // Nobody hears that it leaves.
    let out = worker.step(LIMIT + 5_000, WorkerInput::Silence(Question::Bye));
    assert_eq!(out, [WorkerOutput::Leave]);
    let mut stays = WorkerMachine::default();
    stays.step(0, WorkerInput::Begin);
    assert_eq!((stays.wake(), stays.step(Millis::MAX, WorkerInput::Tick)), (None, vec![]));
}
