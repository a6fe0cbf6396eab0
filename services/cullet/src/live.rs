//! The page of runs on this machine while they go on (`cullet run --live`).

use crate::args::WebAddress;
use crate::exit::{CommandError, Exit};
use crate::illustrator::ProcessIllustrator;
use crate::logs;
use crate::shown::lines;
use cullet::LocalPool;
use cullet_files::clock::unix_ms;
use cullet_proto::service::{FileInfo, JobCounts, RunInfo, State};
use cullet_run::News;
use cullet_web::{FarmNews, Feed, RunNews, WebConfig, Website};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// How long the page stays when all is over and somebody watches.
const LINGER: Duration = Duration::from_secs(10);
/// Between looks.
const LOOK: Duration = Duration::from_millis(100);
/// What a run leaves that the page shows.
const PRODUCTS: [&str; 5] =
    ["run.mcap", "summary.json", "preview.png", "preview.gif", "timeline.svg"];

/// A page of runs one after another.
pub(crate) struct LivePage {
    feed: Feed,
    _site: Website,
    since: Instant,
    runs: Vec<RunNews>,
    /// The one that goes on.
    at: usize,
}

impl LivePage {
    /// Serves the page, if it is wished: of runs with these names and what is set for each.
    pub(crate) fn open(
        wished: Option<WebAddress>,
        runs: impl Iterator<Item = (String, Vec<String>)>,
        quiet: bool,
    ) -> Result<Option<Self>, CommandError> {
        let Some(WebAddress { address, tls }) = wished else { return Ok(None) };
        if tls {
            let text = format!("--live tls/{address}: a run is shown on this machine alone");
            return Err(CommandError::new(Exit::Usage, text));
        }
        let broken = |error: &dyn std::fmt::Display| CommandError::new(Exit::Broken, error);
        let illustrator = Arc::new(ProcessIllustrator::new().map_err(|error| broken(&error))?);
        let (feed, identity) = (Feed::default(), None);
        let config = WebConfig { address, identity, illustrator };
        let site = Website::serve(config, feed.clone()).map_err(|error| broken(&error))?;
        if !quiet {
            let address = site.address().unwrap_or(address);
            logs::say(format!("the page of this run is at http://{address}/"));
        }
        let now = unix_ms();
        let news = |(index, (name, overrides)): (usize, (String, Vec<String>))| RunNews {
            info: RunInfo {
                run: index as u64 + 1,
                name,
                user: String::new(),
                sweep: String::new(),
                ticket: String::new(),
                overrides,
                state: State::Queued,
                priority: 0,
                attempt: 1,
                code: None,
                text: String::new(),
                submitted_ms: now,
                started_ms: None,
                ended_ms: None,
                files: Vec::new(),
                position: None,
                jobs: JobCounts::default(),
            },
            folder: None,
            line: String::new(),
        };
        let runs = runs.enumerate().map(news).collect();
        Ok(Some(Self { feed, _site: site, since: Instant::now(), runs, at: 0 }))
    }

    /// A run begins, and records there.
    pub(crate) fn begin(&mut self, run: usize, folder: &Path, pool: &LocalPool) {
        self.at = run;
        if let Some(news) = self.runs.get_mut(run) {
            news.info.state = State::Running;
            news.info.started_ms = Some(unix_ms());
            news.folder = Some(folder.to_owned());
        }
        self.publish(pool);
    }

    /// What the run says.
    pub(crate) fn show(&mut self, news: &News, pool: &LocalPool) {
        let due = self.feed.is_due();
        let Some(run) = self.runs.get_mut(self.at) else { return };
        match news {
            News::Line(line) | News::Results(line) => run.line = lines(line),
            News::At(position) => run.info.position = Some(*position),
        }
        if due {
            self.publish(pool);
        }
    }

    /// The run is over, with that code; why it is not done, if it is not.
    pub(crate) fn end(&mut self, exit: Exit, why: &str, pool: &LocalPool) {
        let Some(run) = self.runs.get_mut(self.at) else { return };
        let info = &mut run.info;
        info.state = match exit {
            Exit::Done | Exit::Unmet | Exit::Unpictured => State::Done,
            Exit::Interrupted => State::Cancelled,
            Exit::Stalled => State::Stalled,
            _ => State::Failed,
        };
        (info.code, info.text) = (Some(exit.code()), why.to_owned());
        (info.ended_ms, info.position) = (Some(unix_ms()), None);
        let file = |name: &&str| {
            let path = run.folder.as_ref()?.join(name);
            let length = path.metadata().ok()?.len();
            Some(FileInfo { name: (*name).to_owned(), length, digest: String::new() })
        };
        info.files = PRODUCTS.iter().filter_map(file).collect();
        self.publish(pool);
    }

    /// All is over: stays while somebody watches, but not for long.
    pub(crate) fn linger(&self, pool: &LocalPool, stop: &AtomicBool, quiet: bool) {
        let since = Instant::now();
        if self.feed.watchers() > 0 && !quiet {
            logs::say(format!("the page stays for {} s more", LINGER.as_secs()));
        }
        while self.feed.watchers() > 0 && since.elapsed() < LINGER && !stop.load(Ordering::Relaxed)
        {
            sleep(LOOK);
            if self.feed.is_due() {
                self.publish(pool);
            }
        }
    }

    fn publish(&self, pool: &LocalPool) {
        let (jobs_waiting, jobs_running) = pool.jobs();
        self.feed.publish(FarmNews {
            name: String::new(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            now_ms: unix_ms(),
            up_ms: self.since.elapsed().as_millis() as u64,
            runs_at_once: 1,
            free_bytes: None,
            jobs_waiting,
            jobs_running,
            runs: self.runs.clone(),
            workers: pool.workers(),
        });
    }
}
