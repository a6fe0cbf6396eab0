use super::super::synthetic::{self, BREAK, STEP, STEPS};
use super::super::{Event, RecordError, Recorder};
use super::RunTrail;
use std::path::Path;

/// Records a run by hand that follows the one in `base`, with an event more at a step.
fn following(base: &Path, until: u64, more: Option<u64>) -> Result<String, RecordError> {
    let trail = RunTrail::read(&base.join("run.mcap"))?;
    let path = base.join("again.mcap");
    let mut recorder = Recorder::create(&path, &synthetic::meta())?;
    recorder.follow(trail, until);
    let mut recorder = synthetic::born(recorder)?;
    for step in 0..=STEPS {
        if more == Some(step) {
            let gate = Event::Gate { body: 0, reason: "an event more".to_owned() };
            recorder.event(step, step as f64 * STEP, &gate)?;
        }
        synthetic::step(&mut recorder, step)?;
    }
    Ok(recorder.finish(STEPS, STEPS as f64 * STEP)?.summary.digest)
}

fn refused(outcome: Result<String, RecordError>) -> (u64, u64, &'static str) {
    match outcome {
        Err(RecordError::Differs { step, until, what, .. }) => (step, until, what),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_run_is_as_another_one_up_to_a_step_or_refused_with_the_first_that_differs() {
    let dir = tempfile::tempdir().expect("a folder");
    let base = dir.path();
    synthetic::run(&base.join("run.mcap"), &synthetic::meta()).expect("records");
    let trail = RunTrail::read(&base.join("run.mcap")).expect("reads");
    assert_eq!((trail.last_step(), trail.step()), (STEPS, STEP));
    let plain = following(base, STEPS, None).expect("the same up to its last step");
    assert_eq!(following(base, 0, None).as_ref().ok(), Some(&plain), "nothing is compared");
    // The grains of this run are rounded in the file.
    let later = following(base, BREAK + 10, Some(BREAK + 10)).expect("from that step on");
    assert_ne!(later, plain);
    let what = "what happens";
    assert_eq!(refused(following(base, BREAK + 11, Some(BREAK + 10))), (58, 59, what));
    assert_eq!(refused(following(base, STEPS, Some(BREAK))), (BREAK, STEPS, what));
}

/// What the earlier run has at the last step before the one to resume from is missing here.
#[test]
fn a_run_that_lacks_a_message_of_another_is_refused() {
    let dir = tempfile::tempdir().expect("a folder");
    let base = dir.path();
    let path = base.join("run.mcap");
    let mut recorder = synthetic::begin(&path, &synthetic::meta()).expect("begins");
    for step in 0..=STEPS {
        synthetic::step(&mut recorder, step).expect("records");
        if step == 20 {
            let gate = Event::Gate { body: 0, reason: "gone".to_owned() };
            recorder.event(step, step as f64 * STEP, &gate).expect("records");
        }
    }
    recorder.finish(STEPS, STEPS as f64 * STEP).expect("finishes");
    assert!(following(base, 20, None).is_ok());
    assert_eq!(refused(following(base, 21, None)).0, 20);
}

#[test]
fn what_is_cut_off_is_followed_as_far_as_it_goes_and_what_is_damaged_is_not() {
    let dir = tempfile::tempdir().expect("a folder");
    let base = dir.path();
    let path = base.join("run.mcap");
    synthetic::run(&path, &synthetic::meta()).expect("records");
    let bytes = std::fs::read(&path).expect("a recording");
    let partial = base.join("run.mcap.partial");
    std::fs::remove_file(&path).expect("it goes");
    let cut_at = |tenth: usize| {
        std::fs::write(&partial, &bytes[..bytes.len() * tenth / 10]).expect("a file");
        RunTrail::read(&path).map_or(0, |trail| trail.last_step())
    };
    let last = (1..10).rev().map(cut_at).find(|last| (1..STEPS).contains(last));
    let last = last.expect("a part of the run");
    following(base, last, Some(last)).expect("as far as it goes");
    assert_eq!(refused(following(base, last, Some(last - 1))).0, last - 1);
    let mut damaged = std::fs::read(&partial).expect("what was cut off");
    let middle = damaged.len() / 2;
    damaged[middle] ^= 1;
    std::fs::write(&path, damaged).expect("a file");
    let outcome = RunTrail::read(&path);
    assert!(matches!(outcome, Err(RecordError::Patchy { .. })), "{outcome:?}");
}
