//! A timeline as a picture and as a trace.

use super::{Bar, JobTimes, Span, Timeline};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fmt::Write;

/// Names of rows, each once, in order.
fn rows(jobs: &[JobTimes]) -> Vec<&str> {
    let mut names: Vec<&str> =
        jobs.iter().flat_map(|job| job.bars().into_iter().map(|bar| bar.who)).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// The trace, as Chrome's `about:tracing` and Perfetto read it.
pub(crate) fn trace(name: &str, timeline: &Timeline) -> String {
    let jobs = &timeline.jobs;
    let rows = rows(jobs);
    let row = |who: &str| rows.iter().position(|name| *name == who).unwrap_or(0);
    let mut events: Vec<Value> = vec![
        json!({"ph": "M", "pid": 1, "tid": 0, "name": "process_name", "args": {"name": name}}),
    ];
    for (tid, worker) in rows.iter().enumerate() {
        events.push(thread(tid, worker));
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
    if timeline.spans.len() > 1 {
        events.extend(lives(timeline, rows.len()));
    }
    json!({"displayTimeUnit": "ms", "traceEvents": events}).to_string()
}

fn thread(tid: usize, name: &str) -> Value {
    json!({"ph": "M", "pid": 1, "tid": tid, "name": "thread_name", "args": {"name": name}})
}

/// The attempts, and what lies between them, on a line of their own.
fn lives(timeline: &Timeline, tid: usize) -> Vec<Value> {
    let span = |name: &str, cat: &str, (from, to): (f64, f64), what: &str| {
        json!({
            "ph": "X", "pid": 1, "tid": tid, "name": name, "cat": cat,
            "ts": (from * 1e6).round(), "dur": ((to - from) * 1e6).round(), "args": {"what": what},
        })
    };
    let mut events = vec![thread(tid, "the run")];
    for one in &timeline.spans {
        let name = format!("attempt {}", one.attempt);
        events.push(span(&name, "attempt", (one.from, one.to), "the run went on"));
    }
    for gap in timeline.gaps() {
        let name = if gap.cut_off { "coordinator away" } else { "paused" };
        events.push(span(name, "away", (gap.from, gap.to), gap.what()));
    }
    events
}

const WIDTH: f64 = 960.0;
const LEFT: f64 = 150.0;
const ROW: f64 = 16.0;
const TOP: f64 = 48.0;
/// A time between attempts is drawn no longer than this part of the attempts: a night in which
/// nothing went on leaves room for what did.
const GAP: f64 = 0.1;
/// How wide a letter in a bar is, about.
const LETTER: f64 = 5.5;
/// Most round times that are shown, about.
const ROUND: f64 = 8.0;

impl Timeline {
    /// Round times while the run went on \[s\].
    fn round_times(&self) -> Vec<f64> {
        let most = self.drawn(self.end()) * 1e3 / ROUND;
        let steps = (0..15).flat_map(|power| [1, 2, 5].map(|digit| digit * 10_u64.pow(power)));
        let step = steps.into_iter().find(|step| *step as f64 >= most).unwrap_or(u64::MAX);
        let of = |span: &Span| {
            let at = |time: f64| time * 1e3 / step as f64;
            let (first, last) = (at(span.from).ceil() as u64, at(span.to) as u64);
            (first..=last).map(move |k| (k * step) as f64 / 1e3)
        };
        self.spans.iter().flat_map(of).collect()
    }

    /// Where a time is drawn: as what it is, less what gaps are drawn shorter than they are.
    pub(super) fn drawn(&self, time: f64) -> f64 {
        let going: f64 = self.spans.iter().map(|span| span.to - span.from).sum();
        let saved = self.gaps().map(|gap| {
            let length = gap.to - gap.from;
            let passed = (time - gap.from).clamp(0.0, length);
            let kept = length.min(GAP * going.max(1e-3));
            if length > kept { passed * (1.0 - kept / length) } else { 0.0 }
        });
        time - saved.sum::<f64>()
    }

    /// What is said above the picture.
    fn heading(&self, name: &str) -> String {
        // One that was kept was there before.
        let jobs = self.jobs.iter().map(|job| job.job.as_str()).collect::<BTreeSet<_>>().len();
        let (end, count) = (self.end(), self.spans.len());
        let attempts = match count {
            0 | 1 => String::new(),
            _ => format!(", {count} attempts, shaded between them"),
        };
        let untold = if self.untold { "; of earlier attempts not all is told" } else { "" };
        format!("{}: {jobs} jobs in {end:.2} s{attempts}{untold}", escape(name))
    }
}

/// The picture: a line a job, by the worker whose result counts: a thin one while it waits, a bar
/// while it is at a worker.
pub(crate) fn svg(name: &str, timeline: &Timeline) -> String {
    let end = timeline.drawn(timeline.end()).max(1e-3);
    let across = |time: f64| LEFT + (WIDTH - LEFT - 20.0) * timeline.drawn(time) / end;
    let mut sorted: Vec<&JobTimes> = timeline.jobs.iter().collect();
    sorted.sort_by(|a, b| a.who().cmp(b.who()).then(a.opened.total_cmp(&b.opened)));
    let height = TOP + ROW * sorted.len() as f64 + 30.0;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" \
         font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#fafafa\"/>\n\
         <text x=\"10\" y=\"20\" font-size=\"14\">{}</text>\n\
         <text x=\"10\" y=\"36\" fill=\"#666\">thin: waits; bar: at a worker; blue solved, light \
         blue overtaken, orange lost, grey kept or cached, light grey not settled, red refused, \
         failed or given up</text>\n",
        timeline.heading(name),
    );
    for gap in timeline.gaps() {
        let (x, end) = (across(gap.from), across(gap.to));
        let _ = writeln!(
            out,
            "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{}\">\
             <title>{:.3}–{:.3} s: {}</title></rect>",
            TOP - 6.0,
            (end - x).max(1.0),
            height - TOP,
            if gap.cut_off { "#f3d9d3" } else { "#e4e7ec" },
            gap.from,
            gap.to,
            gap.what(),
        );
    }
    axis(&mut out, timeline, height, &across);
    let mut last = "";
    for (index, job) in sorted.iter().enumerate() {
        let y = TOP + ROW * index as f64;
        if job.who() != last {
            last = job.who();
            let label = escape(last);
            let _ = writeln!(out, "<text x=\"10\" y=\"{:.1}\">{label}</text>", y + 11.0);
        }
        line(&mut out, job, y, &across);
    }
    out + "</svg>\n"
}

/// Lines at round times while the run went on, with what they are.
fn axis(out: &mut String, timeline: &Timeline, height: f64, across: &dyn Fn(f64) -> f64) {
    for time in timeline.round_times() {
        let (x, end, text) = (across(time), height - 20.0, height - 8.0);
        let _ = writeln!(
            out,
            "<path d=\"M{x:.1} {:.1}V{end:.1}\" stroke=\"#ddd\"/>\
             <text x=\"{x:.1}\" y=\"{text:.1}\" text-anchor=\"middle\" fill=\"#666\">\
             {time} s</text>",
            TOP - 4.0,
        );
    }
}

/// One job.
fn line(out: &mut String, job: &JobTimes, y: f64, across: &dyn Fn(f64) -> f64) {
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
        label(out, job, &bar, (x, end, y + ROW - 5.0));
    }
}

/// How long a bar is, and whose it is where it is not its row's, if there is room for it.
fn label(out: &mut String, job: &JobTimes, bar: &Bar<'_>, (from, to, y): (f64, f64, f64)) {
    let whose = if bar.who == job.who() { String::new() } else { format!("{}: ", bar.who) };
    let text = format!("{whose}{:.2} s", bar.to - bar.from);
    if to - from > LETTER * (text.chars().count() + 2) as f64 {
        let (x, text) = (from + LETTER, escape(&text));
        let _ = writeln!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"9\">{text}</text>");
    }
}

pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
