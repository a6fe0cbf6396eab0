use super::picture::escape;
use super::{JobFate, JobTimes, Stretch, Timeline, svg, trace};

fn jobs() -> Vec<JobTimes> {
    let job = |worker: &str, opened, settled, attempts, kept| JobTimes {
        job: format!("{opened:08}"),
        worker: worker.into(),
        opened,
        settled,
        attempts,
        kept,
        tries: Vec::new(),
        ending: JobFate::Solved,
    };
    let at = |worker: &str, from, to, lost: &str| {
        let (worker, lost) = (worker.to_owned(), lost.to_owned());
        Stretch { worker, from, to, lost }
    };
    let mut first = job("b", 0.0, 1.0, 1, false);
    first.tries = vec![at("b", 0.25, 0.75, "")];
    let mut second = job("a", 0.5, 2.0, 2, false);
    second.tries = vec![at("c", 0.75, 1.0, "Down (<x>)"), at("a", 1.25, 9.0, "")];
    vec![first, second, job("", 2.0, 2.0, 0, true)]
}

#[test]
fn every_job_is_in_both_with_its_worker_and_times() {
    let said: serde_json::Value =
        serde_json::from_str(&trace("pot", &Timeline::of(jobs()))).expect("JSON");
    let events = said["traceEvents"].as_array().expect("events");
    let spans: Vec<_> = events.iter().filter(|event| event["ph"] == "X").collect();
    // From the grant to the result, at whom it was; nothing after it had settled.
    let whole = |event: &serde_json::Value| {
        ["tid", "ts", "dur"].map(|key| event[key].as_f64().unwrap_or(f64::NAN))
    };
    let spans: Vec<_> = spans.into_iter().map(whole).collect();
    let due = [[1.0, 0.25e6, 0.5e6], [2.0, 0.75e6, 0.25e6], [0.0, 1.25e6, 0.75e6]];
    assert_eq!(spans[..3], due);
    let waits = events.iter().filter(|event| event["cat"] == "waiting");
    let waits: Vec<_> = waits.map(|event| event["ts"].as_f64().unwrap_or(-1.0)).collect();
    assert_eq!(waits[..4], [0.0, 0.25e6, 0.5e6, 0.75e6]);
    let names: Vec<_> = events.iter().filter(|e| e["name"] == "thread_name").collect();
    assert_eq!(names.len(), 4, "a, b, c and kept");
    let picture = svg("<pot>", &Timeline::of(jobs()));
    assert_eq!(picture.matches("<title>").count(), 4);
    assert!(picture.contains("&lt;pot&gt;") && picture.contains("#d98b2b"));
    assert!(svg("empty", &Timeline::of(Vec::new())).ends_with("</svg>\n"));
}

#[test]
fn the_picture_has_an_axis_and_says_how_long_bars_are_and_whose() {
    let times = |timeline: &Timeline| -> Vec<f64> {
        let picture = svg("pot", timeline);
        let labels = picture.lines().filter(|line| line.starts_with("<path"));
        let labels = labels.filter_map(|line| line.split_once("#666\">"));
        let time = |(_, text): (&str, &str)| text.split_once(" s<")?.0.parse().ok();
        labels.filter_map(time).collect()
    };
    let mut two = Timeline::of(jobs());
    assert_eq!(times(&two), [0.0, 0.5, 1.0, 1.5, 2.0]);
    // A night between two attempts has none; a second attempt goes on with the times of the run.
    two.add((2, 40_000_000), jobs(), 0.0, true);
    assert_eq!(times(&two), [0.0, 1.0, 2.0, 40_000.0, 40_001.0, 40_002.0]);
    assert_eq!(times(&Timeline::of(Vec::new())), [0.0]);
    let picture = svg("pot", &Timeline::of(jobs()));
    let told = ["0.50 s", "c: 0.25 s"].map(|text| picture.contains(&format!(">{text}</text>")));
    assert_eq!(told, [true; 2], "{picture}");
}

/// What the bars say, in the picture and in the trace.
fn told(jobs: Vec<JobTimes>) -> Vec<(String, String)> {
    let timeline = Timeline::of(jobs);
    let said: serde_json::Value = serde_json::from_str(&trace("pot", &timeline)).expect("JSON");
    let events = said["traceEvents"].as_array().expect("events").iter();
    let spans = events.filter(|event| event["ph"] == "X");
    let words = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
    let told = spans.map(|e| (words(&e["args"]["ending"]), words(&e["args"]["what"])));
    let told: Vec<_> = told.collect();
    let picture = svg("pot", &timeline);
    for (_, text) in &told {
        let text = escape(text);
        assert!(picture.contains(&format!(" s: {text}</title>")), "{text}: {picture}");
    }
    told
}

#[test]
fn a_bar_says_what_became_of_its_attempt() {
    let all = told(jobs());
    let due = [
        ("solved", "solved; attempt 1 of 1"),
        (
            "lost",
            "lost with c (its process or its link ended (<x>)); sent again to a; \
         attempt 1 of 2",
        ),
        ("solved", "solved; attempt 2 of 2"),
        ("solved", "solved before: nobody was asked"),
    ];
    let due: Vec<_> = due.map(|(ending, text)| (ending.to_owned(), text.to_owned())).into();
    assert_eq!(all, due);
}

#[test]
fn what_was_given_up_overtaken_or_left_is_told_so() {
    let [_, job, _] = &jobs()[..] else { panic!("three jobs") };
    let (mut poison, mut hedged, mut left) = (job.clone(), job.clone(), job.clone());
    (poison.ending, poison.worker) = (JobFate::Abandoned, String::new());
    poison.tries[1].lost = "Crashed: a signal".into();
    hedged.tries[0].lost.clear();
    (left.ending, left.tries) = (JobFate::Unsettled, Vec::new());
    left.worker.clear();
    let said = |job: &JobTimes| told(vec![job.clone()]);
    assert_eq!(said(&poison)[1].1, {
        "lost with a (its solver died: a signal); the job was given up; attempt 2 of 2"
    });
    assert_eq!(said(&hedged)[0].0, "overtaken");
    assert_eq!(said(&left)[0].1, "not settled when the run was over");
}
