//! What goes to standard error: words for people, and log lines. With `--log json` both are JSON
//! objects, one a line, and nothing else is there.

use crate::args::{Log, Voice};
use crate::exit::CommandError;
use crate::shown::{self, shown};
use serde::Serialize;
use serde_json::{Map, Value};
use std::fmt;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use tracing::field::{Field, Visit};
use tracing::{Event, Subscriber};
use tracing_subscriber::EnvFilter;
use tracing_subscriber::field::MakeExt;
use tracing_subscriber::fmt::format::{JsonFields, Writer, debug_fn};
use tracing_subscriber::fmt::time::{FormatTime, SystemTime};
use tracing_subscriber::fmt::{FmtContext, FormatEvent, FormattedFields};
use tracing_subscriber::registry::{LookupSpan, Scope};

/// Whether everything is JSON.
static JSON: AtomicBool = AtomicBool::new(false);
/// Whether errors are.
static OBJECTS: AtomicBool = AtomicBool::new(false);

/// Sends log lines to standard error: warnings, or more on request. As JSON, for programs, they
/// have the life of runs and jobs in any case.
pub(crate) fn start(voice: &Voice) {
    let level = match (voice.quiet, voice.log, voice.verbose) {
        (true, ..) => "error",
        (false, Log::Text, 0) => "warn,zenoh=error",
        (false, Log::Json, 0) => "warn,cullet=info,zenoh=error",
        (false, Log::Text, 1) => "info,zenoh=warn",
        (false, Log::Json, 1) => "info,cullet=debug,zenoh=warn",
        (false, ..) => "debug",
    };
    let filter = EnvFilter::try_from_env("CULLET_LOG").unwrap_or_else(|_| EnvFilter::new(level));
    let colours = std::io::IsTerminal::is_terminal(&std::io::stderr())
        && std::env::var_os("NO_COLOR").is_none_or(|set| set.is_empty());
    let logs = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_ansi(colours)
        .log_internal_errors(false)
        .with_writer(|| Deaf);
    match voice.log {
        Log::Text => logs.fmt_fields(debug_fn(field).delimited(" ")).init(),
        Log::Json => {
            JSON.store(true, Ordering::Relaxed);
            logs.fmt_fields(JsonFields::new()).event_format(JsonLine).init();
            std::panic::set_hook(Box::new(|panic| tracing::error!("{panic}")));
        }
    }
}

/// Standard error, whether or not it can be written: a process does not end because nobody hears
/// it. (`eprintln!` would panic.)
struct Deaf;

impl Write for Deaf {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let _nobody_hears_it = io::stderr().write_all(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Puts a line there, in one piece.
fn line(text: impl fmt::Display) {
    let text = format!("{text}\n");
    let _always = Deaf.write_all(shown::output(&text).as_bytes());
}

/// A field of a log line for people. An event is one line, whatever is in it.
fn field(writer: &mut Writer<'_>, field: &Field, value: &dyn fmt::Debug) -> fmt::Result {
    let text = format!("{value:?}");
    match field.name() {
        "message" => writer.write_str(&shown(&text)),
        name => write!(writer, "{}={}", name.trim_start_matches("r#"), shown(&text)),
    }
}

/// Says something that a person wants to know.
pub(crate) fn say(text: impl fmt::Display) {
    match JSON.load(Ordering::Relaxed) {
        true => tracing::info!("{text}"),
        false => line(text),
    }
}

/// Says what is not as it should be.
pub(crate) fn warn(text: impl fmt::Display) {
    match JSON.load(Ordering::Relaxed) {
        true => tracing::warn!("{text}"),
        false => line(format_args!("warning: {text}")),
    }
}

/// Says why something is not done: in words, or, to whom wants results as JSON, as an object.
pub(crate) fn error(trouble: &CommandError) {
    match (JSON.load(Ordering::Relaxed), OBJECTS.load(Ordering::Relaxed)) {
        (true, _) => {
            let (code, kind, place) = (trouble.exit.code(), trouble.exit.word(), trouble.place());
            tracing::error!(code, kind, place, cause = trouble.cause(), "{trouble}");
        }
        (false, true) => line(trouble.json()),
        (false, false) => line(format_args!("error: {trouble}")),
    }
}

/// Errors are objects from now on, where somebody has asked for results as JSON; whether so.
pub(crate) fn as_asked() -> bool {
    let wanted = std::env::args().skip(1).take_while(|word| word != "--").any(|w| w == "--json");
    OBJECTS.store(wanted, Ordering::Relaxed);
    wanted
}

/// Whether somebody whose arguments are not understood has asked for JSON.
pub(crate) fn asked() -> bool {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let apart = words.windows(2).any(|pair| pair == ["--log", "json"]);
    apart || words.iter().any(|word| word == "--log=json")
}

/// Whether it is for people: a bar that grows is no line.
pub(crate) fn plain() -> bool {
    !JSON.load(Ordering::Relaxed)
}

/// A line of JSON. What the spans say that it is in is said by the line itself.
struct JsonLine;

/// A log event as a line of JSON.
#[derive(Serialize)]
struct LogLine<'a> {
    timestamp: String,
    level: &'a str,
    target: &'a str,
    #[serde(flatten)]
    fields: Map<String, Value>,
}

impl<S> FormatEvent<S, JsonFields> for JsonLine
where
    S: Subscriber + for<'a> LookupSpan<'a>,
{
    fn format_event(
        &self,
        context: &FmtContext<'_, S, JsonFields>,
        mut writer: Writer<'_>,
        event: &Event<'_>,
    ) -> fmt::Result {
        let mut fields = LogFields::default();
        for span in context.event_scope().into_iter().flat_map(Scope::from_root) {
            let extensions = span.extensions();
            let known = extensions.get::<FormattedFields<JsonFields>>();
            let known = known.and_then(|text| serde_json::from_str(&text.fields).ok());
            fields.0.extend(known.unwrap_or_else(Map::new));
        }
        event.record(&mut fields);
        let mut timestamp = String::new();
        SystemTime.format_time(&mut Writer::new(&mut timestamp))?;
        let (level, target) = (event.metadata().level().as_str(), event.metadata().target());
        let told = LogLine { timestamp, level, target, fields: fields.0 };
        let line = serde_json::to_string(&told).map_err(|_| fmt::Error)?;
        writeln!(writer, "{}", shown::output(&line))
    }
}

/// The fields of one line.
#[derive(Default)]
struct LogFields(Map<String, Value>);

impl LogFields {
    fn put(&mut self, field: &Field, value: impl Into<Value>) {
        self.0.insert(field.name().to_owned(), value.into());
    }
}

impl Visit for LogFields {
    fn record_f64(&mut self, field: &Field, value: f64) {
        self.put(field, value);
    }

    fn record_i64(&mut self, field: &Field, value: i64) {
        self.put(field, value);
    }

    fn record_u64(&mut self, field: &Field, value: u64) {
        self.put(field, value);
    }

    fn record_bool(&mut self, field: &Field, value: bool) {
        self.put(field, value);
    }

    fn record_str(&mut self, field: &Field, value: &str) {
        self.put(field, value);
    }

    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        self.put(field, format!("{value:?}"));
    }
}

#[cfg(test)]
mod tests {
    use super::{JsonFields, JsonLine, MakeExt, debug_fn, field};
    use serde_json::Value;
    use std::io::Write;
    use std::sync::{Arc, Mutex};

    #[derive(Clone, Default)]
    struct Page(Arc<Mutex<Vec<u8>>>);

    impl Write for Page {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.lock().expect("a page").write(bytes)
        }

        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn what_others_say_stays_text_on_one_line() {
        let page = Page::default();
        let writer = page.clone();
        let logs = tracing_subscriber::fmt().with_ansi(false).with_writer(move || writer.clone());
        let logs = logs.fmt_fields(debug_fn(field).delimited(" ")).finish();
        tracing::subscriber::with_default(logs, || {
            let name = "w\u{9b}1m";
            tracing::warn!(name, by = %"\u{202e}x", "\u{1b}]0;title\u{7} is\rhere\nand there");
        });
        let text = String::from_utf8(page.0.lock().expect("a page").clone()).expect("text");
        let line = text.strip_suffix('\n').expect("a line");
        assert!(!line.contains(|c: char| c.is_control() || c == '\u{202e}'), "{line:?}");
        let told = r"\u001b]0;title\u0007 is\rhere\nand there";
        assert!(line.contains(told) && line.contains(r"by=\u202ex"), "{line}");
    }

    #[test]
    fn a_line_has_what_its_spans_have_and_is_one_line() {
        let page = Page::default();
        let writer = page.clone();
        let logs = tracing_subscriber::fmt().with_writer(move || writer.clone());
        let logs = logs.fmt_fields(JsonFields::new()).event_format(JsonLine).finish();
        tracing::subscriber::with_default(logs, || {
            let _run = tracing::info_span!("run", run = 7).entered();
            let job = "ab\"c\n";
            tracing::info!(job, attempts = u64::MAX, kept = true, ending = ?Some(1), "settled\nso");
        });
        let text = String::from_utf8(page.0.lock().expect("a page").clone()).expect("text");
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 1, "{text}");
        let line: Value = serde_json::from_str(lines[0]).expect("JSON");
        assert_eq!((&line["run"], &line["level"]), (&7.into(), &"INFO".into()));
        assert_eq!((&line["job"], &line["message"]), (&"ab\"c\n".into(), &"settled\nso".into()));
        assert_eq!((&line["attempts"], &line["kept"]), (&u64::MAX.into(), &true.into()));
        assert_eq!(line["ending"], "Some(1)");
        assert!(line["timestamp"].as_str().is_some_and(|at| at.ends_with('Z')), "{line}");
    }
}
