//! Who solved what and when in a run: as a picture (SVG) and as a trace that Chrome and Perfetto
//! open.

use serde_json::{Value, json};
use std::fmt::Write;

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
        match (self.kept, self.attempts > 1, self.ending) {
            (true, ..) => "#8a8f98",
            (false, true, _) => "#d98b2b",
            (false, false, "solved") => "#3f7fb5",
            (false, false, _) => "#b5483f",
        }
    }
}

/// Names of rows, each once, in order.
fn rows(jobs: &[Job]) -> Vec<&str> {
    let mut names: Vec<&str> = jobs.iter().map(Job::who).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// The trace, as Chrome's `about:tracing` and Perfetto read it.
pub(super) fn trace(name: &str, jobs: &[Job]) -> String {
    let rows = rows(jobs);
    let row = |job: &Job| rows.iter().position(|name| *name == job.who()).unwrap_or(0);
    let mut events: Vec<Value> = vec![
        json!({"ph": "M", "pid": 1, "tid": 0, "name": "process_name", "args": {"name": name}}),
    ];
    for (tid, worker) in rows.iter().enumerate() {
        let args = json!({"name": worker});
        events.push(json!({"ph": "M", "pid": 1, "tid": tid, "name": "thread_name", "args": args}));
    }
    for job in jobs {
        let args = json!({"ending": job.ending, "attempts": job.attempts, "kept": job.kept});
        let (start, length) = (job.opened * 1e6, (job.settled - job.opened) * 1e6);
        events.push(json!({
            "ph": "X", "pid": 1, "tid": row(job), "name": job.job, "cat": "job",
            "ts": start.round(), "dur": length.round(), "args": args,
        }));
    }
    json!({"displayTimeUnit": "ms", "traceEvents": events}).to_string()
}

const WIDTH: f64 = 960.0;
const LEFT: f64 = 150.0;
const ROW: f64 = 16.0;
const TOP: f64 = 48.0;

/// The picture: a line a job, by worker, from when it was wanted to when it had settled.
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
         <text x=\"10\" y=\"36\" fill=\"#666\">blue solved, orange sent again, grey kept or \
         cached, red refused or failed</text>\n",
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
        let (x, to) = (across(job.opened), across(job.settled));
        let _ = writeln!(
            out,
            "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{}\">\
             <title>{} {} {:.3}–{:.3} s, {} attempts</title></rect>",
            y + 2.0,
            (to - x).max(1.0),
            ROW - 4.0,
            job.colour(),
            job.job,
            job.ending,
            job.opened,
            job.settled,
            job.attempts,
        );
    }
    out + "</svg>\n"
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::{Job, svg, trace};

    fn jobs() -> Vec<Job> {
        let job = |worker: &str, opened, settled, attempts, kept| Job {
            job: format!("{opened:08}"),
            worker: worker.into(),
            opened,
            settled,
            attempts,
            kept,
            ending: "solved",
        };
        vec![job("b", 0.0, 1.0, 1, false), job("a", 0.5, 2.0, 2, false), job("", 2.0, 2.0, 0, true)]
    }

    #[test]
    fn every_job_is_in_both_with_its_worker_and_times() {
        let said: serde_json::Value = serde_json::from_str(&trace("pot", &jobs())).expect("JSON");
        let events = said["traceEvents"].as_array().expect("events");
        let spans: Vec<_> = events.iter().filter(|event| event["ph"] == "X").collect();
        assert_eq!(spans.len(), 3);
        assert_eq!((&spans[1]["ts"], &spans[1]["dur"]), (&500_000.0.into(), &1_500_000.0.into()));
        assert_ne!(spans[0]["tid"], spans[1]["tid"]);
        let names: Vec<_> = events.iter().filter(|e| e["name"] == "thread_name").collect();
        assert_eq!(names.len(), 3, "a, b and kept");
        let picture = svg("<pot>", &jobs());
        assert_eq!(picture.matches("<title>").count(), 3);
        assert!(picture.contains("&lt;pot&gt;") && picture.contains("#d98b2b"));
        assert!(svg("empty", &[]).ends_with("</svg>\n"));
    }
}
