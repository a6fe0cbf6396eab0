//! Who solved what and when in a run: as a picture (SVG) and as a trace that Chrome and Perfetto
//! open.

use serde_json::{Value, json};
use std::fmt::Write;

/// A job at a worker.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Stretch {
    /// Whose.
    pub(super) worker: String,
    /// Wall time since the run's attempt began at which the worker got the job \[s\].
    pub(super) from: f64,
    /// The same at which it was over \[s\].
    pub(super) to: f64,
    /// How it was lost; empty: it was not.
    pub(super) lost: String,
}

/// A fracture job of a run that settled.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Job {
    /// The first digits of its id.
    pub(super) job: String,
    /// Whose result counts.
    pub(super) worker: String,
    /// Wall time since the attempt began at which it was wanted \[s\].
    pub(super) opened: f64,
    /// The same at which the run had its verdict \[s\].
    pub(super) settled: f64,
    /// Attempts made.
    pub(super) attempts: u32,
    /// Whether it was answered from what had been kept.
    pub(super) kept: bool,
    /// When it was at which worker.
    pub(super) tries: Vec<Stretch>,
    /// How it ended.
    pub(super) ending: &'static str,
}

impl Job {
    fn who(&self) -> &str {
        match (self.kept, self.worker.as_str()) {
            (true, _) => "kept",
            (false, "") => "nobody",
            (false, worker) => worker,
        }
    }

    fn colour(&self) -> &'static str {
        match (self.kept, self.ending) {
            (true, _) => "#8a8f98",
            (false, "solved") => "#3f7fb5",
            (false, UNSETTLED) => "#c4c8ce",
            (false, _) => "#b5483f",
        }
    }

    /// When the first worker got it, or it was over without one.
    fn granted(&self) -> f64 {
        self.tries.first().map_or(self.settled, |first| first.from.max(self.opened))
    }

    /// When it was where, and what came of it.
    fn bars(&self) -> Vec<Bar<'_>> {
        let bar = |(index, one)| self.bar(index, one);
        let tries: Vec<Bar<'_>> = self.tries.iter().enumerate().map(bar).collect();
        if !tries.is_empty() {
            return tries;
        }
        let text = match (self.kept, self.ending) {
            (true, ending) => format!("{ending} before: nobody was asked"),
            (false, UNSETTLED) => "not settled when the run was over".to_owned(),
            (false, ending) => ending.to_owned(),
        };
        let (who, from, to, ending) = (self.who(), self.opened, self.settled, self.ending);
        vec![Bar { who, from, to, colour: self.colour(), ending, attempt: 0, text }]
    }

    fn bar<'a>(&'a self, index: usize, one: &'a Stretch) -> Bar<'a> {
        let from = one.from.clamp(self.opened, self.settled);
        let to = one.to.clamp(from, self.settled);
        let (ending, colour, text) = match (one.lost.as_str(), self.ending) {
            ("", ending) if one.worker == self.worker => (ending, self.colour(), ending.to_owned()),
            ("", "solved" | "refused" | "failed") => {
                (OVERTAKEN, LATE, "overtaken: another's result came first".to_owned())
            }
            ("", ending) => (ending, self.colour(), format!("stopped: the job was {ending}")),
            (lost, _) => ("lost", LOST, self.lost(one, &why(lost))),
        };
        let text = format!("{text}; attempt {} of {}", index + 1, self.tries.len());
        Bar { who: &one.worker, from, to, colour, ending, attempt: index + 1, text }
    }

    /// What came of a job when one had lost it.
    fn lost(&self, one: &Stretch, why: &str) -> String {
        let next = self.tries.iter().find(|other| other.from >= one.to);
        let beside = self.tries.iter().find(|other| other.from < one.to && other.to > one.to);
        let then = match (next.or(beside), self.ending) {
            (Some(other), _) if other.from < one.to => format!("{} was at it too", other.worker),
            (Some(next), _) => format!("sent again to {}", next.worker),
            (None, "abandoned") => "the job was given up".to_owned(),
            (None, _) => "not sent again".to_owned(),
        };
        format!("lost with {} ({why}); {then}", one.worker)
    }
}

/// A job at a worker, as it is shown.
struct Bar<'a> {
    who: &'a str,
    from: f64,
    to: f64,
    colour: &'static str,
    /// How it ended, in a word.
    ending: &'static str,
    /// Which attempt, from 1; 0: nobody was asked.
    attempt: usize,
    /// What happened.
    text: String,
}

/// How a job ends that has not when its run is over.
pub(super) const UNSETTLED: &str = "unsettled";
/// How an attempt ends where another one was first.
const OVERTAKEN: &str = "overtaken";
/// The colour of one.
const LATE: &str = "#9ab8d3";

/// Why an attempt was lost, for people: what the pool says, its first word in words.
fn why(lost: &str) -> String {
    let end = lost.find([' ', ':']).unwrap_or(lost.len());
    let words = match &lost[..end] {
        "Down" => "its process or its link ended",
        "Crashed" => "its solver died",
        "Dropped" => "it gave the job back",
        "Silent" => "nothing was heard of it",
        "TooLong" => "it took longer than it may",
        other => other,
    };
    format!("{words}{}", &lost[end..])
}

/// An attempt that was lost.
const LOST: &str = "#d98b2b";

/// Names of rows, each once, in order.
fn rows(jobs: &[Job]) -> Vec<&str> {
    let mut names: Vec<&str> =
        jobs.iter().flat_map(|job| job.bars().into_iter().map(|bar| bar.who)).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// The trace, as Chrome's `about:tracing` and Perfetto read it.
pub(super) fn trace(name: &str, jobs: &[Job]) -> String {
    let rows = rows(jobs);
    let row = |who: &str| rows.iter().position(|name| *name == who).unwrap_or(0);
    let mut events: Vec<Value> = vec![
        json!({"ph": "M", "pid": 1, "tid": 0, "name": "process_name", "args": {"name": name}}),
    ];
    for (tid, worker) in rows.iter().enumerate() {
        let args = json!({"name": worker});
        events.push(json!({"ph": "M", "pid": 1, "tid": tid, "name": "thread_name", "args": args}));
    }
    for (id, job) in jobs.iter().enumerate() {
        for bar in job.bars() {
            let (attempt, attempts) = (bar.attempt, job.attempts);
            let args = json!({
                "ending": bar.ending, "what": bar.text, "attempt": attempt, "attempts": attempts,
                "kept": job.kept,
            });
            let (from, took) = (bar.from * 1e6, (bar.to - bar.from) * 1e6);
            events.push(json!({
                "ph": "X", "pid": 1, "tid": row(bar.who), "name": job.job, "cat": "job",
                "ts": from.round(), "dur": took.round(), "args": args,
            }));
        }
        // Jobs wait side by side: lines of their own, beside those of the workers.
        for (phase, at) in [("b", job.opened), ("e", job.granted())] {
            events.push(json!({
                "ph": phase, "pid": 1, "tid": 0, "name": "waiting", "cat": "waiting", "id": id,
                "ts": (at * 1e6).round(), "args": {"job": job.job},
            }));
        }
    }
    json!({"displayTimeUnit": "ms", "traceEvents": events}).to_string()
}

const WIDTH: f64 = 960.0;
const LEFT: f64 = 150.0;
const ROW: f64 = 16.0;
const TOP: f64 = 48.0;

/// The picture: a line a job, by the worker whose result counts: a thin one while it waits, a bar
/// while it is at a worker.
pub(super) fn svg(name: &str, jobs: &[Job]) -> String {
    let end = jobs.iter().map(|job| job.settled).fold(1e-3, f64::max);
    let across = |time: f64| LEFT + (WIDTH - LEFT - 20.0) * time / end;
    let mut sorted: Vec<&Job> = jobs.iter().collect();
    sorted.sort_by(|a, b| a.who().cmp(b.who()).then(a.opened.total_cmp(&b.opened)));
    let height = TOP + ROW * sorted.len() as f64 + 30.0;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" \
         font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#fafafa\"/>\n\
         <text x=\"10\" y=\"20\" font-size=\"14\">{}: {} jobs in {end:.2} s</text>\n\
         <text x=\"10\" y=\"36\" fill=\"#666\">thin: waits; bar: at a worker; blue solved, light \
         blue overtaken, orange lost, grey kept or cached, light grey not settled, red refused, \
         failed or given up</text>\n",
        escape(name),
        jobs.len(),
    );
    let mut last = "";
    for (index, job) in sorted.iter().enumerate() {
        let y = TOP + ROW * index as f64;
        if job.who() != last {
            last = job.who();
            let label = escape(last);
            let _ = writeln!(out, "<text x=\"10\" y=\"{:.1}\">{label}</text>", y + 11.0);
        }
        let (waits, begins) = (across(job.opened), across(job.granted()));
        let (width, middle) = ((begins - waits).max(0.5), y + ROW / 2.0 - 1.0);
        let _ = writeln!(
            out,
            "<rect x=\"{waits:.1}\" y=\"{middle:.1}\" width=\"{width:.1}\" height=\"2\" \
             fill=\"#c4c8ce\"/>"
        );
        for bar in job.bars() {
            let (x, end) = (across(bar.from), across(bar.to));
            let _ = writeln!(
                out,
                "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{}\">\
                 <title>{} at {} {:.3}–{:.3} s: {}</title></rect>",
                y + 2.0,
                (end - x).max(1.0),
                ROW - 4.0,
                bar.colour,
                job.job,
                escape(bar.who),
                bar.from,
                bar.to,
                escape(&bar.text),
            );
        }
    }
    out + "</svg>\n"
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::{Job, Stretch, svg, trace};

    fn jobs() -> Vec<Job> {
        let job = |worker: &str, opened, settled, attempts, kept| Job {
            job: format!("{opened:08}"),
            worker: worker.into(),
            opened,
            settled,
            attempts,
            kept,
            tries: Vec::new(),
            ending: "solved",
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
        let said: serde_json::Value = serde_json::from_str(&trace("pot", &jobs())).expect("JSON");
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
        let picture = svg("<pot>", &jobs());
        assert_eq!(picture.matches("<title>").count(), 4);
        assert!(picture.contains("&lt;pot&gt;") && picture.contains("#d98b2b"));
        assert!(svg("empty", &[]).ends_with("</svg>\n"));
    }

    /// What the bars say, in the picture and in the trace.
    fn told(jobs: &[Job]) -> Vec<(String, String)> {
        let said: serde_json::Value = serde_json::from_str(&trace("pot", jobs)).expect("JSON");
        let events = said["traceEvents"].as_array().expect("events").iter();
        let spans = events.filter(|event| event["ph"] == "X");
        let words = |value: &serde_json::Value| value.as_str().unwrap_or_default().to_owned();
        let told = spans.map(|e| (words(&e["args"]["ending"]), words(&e["args"]["what"])));
        let told: Vec<_> = told.collect();
        let picture = svg("pot", jobs);
        for (_, text) in &told {
            let text = super::escape(text);
            assert!(picture.contains(&format!(" s: {text}</title>")), "{text}: {picture}");
        }
        told
    }

    #[test]
    fn a_bar_says_what_became_of_its_attempt() {
        let all = told(&jobs());
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
        (poison.ending, poison.worker) = ("abandoned", String::new());
        poison.tries[1].lost = "Crashed: a signal".into();
        hedged.tries[0].lost.clear();
        (left.ending, left.tries) = (super::UNSETTLED, Vec::new());
        left.worker.clear();
        let said = |job: &Job| told(std::slice::from_ref(job));
        assert_eq!(said(&poison)[1].1, {
            "lost with a (its solver died: a signal); the job was given up; attempt 2 of 2"
        });
        assert_eq!(said(&hedged)[0].0, "overtaken");
        assert_eq!(said(&left)[0].1, "not settled when the run was over");
    }
}
