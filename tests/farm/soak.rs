//! A farm under one fault after another while clients hand runs in, watch, cancel, fetch and delete
//! them. In the end all is healed, everything is over with the bits of a quiet machine, and what
//! everybody wrote down is checked as a history.
//!
//! `CULLET_SOAK_S=3600 cargo test --release -p cullet --test farm soak:: -- --nocapture` is an
//! hour; `CULLET_SEED` names what is drawn, `CULLET_SOAK_DIR` a folder in which all that was
//! written stays.

use crate::common;

use common::desk::Desk;
use common::farm::{Draw, Farm, Held, Role};
use common::figures::number;
use common::history::{Act, Heard, Listed, Step, check_jobs, check_runs};
use common::{signal, unique};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Beyond this a soak has quiet minutes.
const LONG: Duration = Duration::from_secs(120);
/// Past this a process holds what it needs.
const GROWN: Duration = Duration::from_secs(10);
/// Workers; the first one is never ended.
const WORKERS: usize = 3;

/// What the clients share.
struct Clients {
    desk: Desk,
    /// Whether nothing new is to be handed in.
    over: AtomicBool,
    /// The last seed.
    seeds: AtomicU64,
}

impl Clients {
    /// Most often a seed that nobody had; one in eight is killed as it hands in.
    fn submit(&self, draw: &mut Draw) -> Option<(u64, u64)> {
        let last = self.seeds.load(Ordering::SeqCst);
        let seed = match last > 3 && draw.below(5) == 0 {
            true => 1 + draw.below(last),
            false => self.seeds.fetch_add(1, Ordering::SeqCst) + 1,
        };
        let killed = (draw.below(8) == 0).then(|| draw.millis(0, 60));
        Some((self.desk.submit(seed, killed)?, seed))
    }

    /// One client, until it is over.
    fn come_and_go(&self, mut draw: Draw, pauses: u64) {
        while !self.over.load(Ordering::SeqCst) {
            if let Some((run, seed)) = self.submit(&mut draw) {
                match draw.below(6) {
                    0 => {
                        sleep(draw.millis(0, 1_500));
                        self.desk.order("cancel", run);
                    }
                    1 => self.desk.watch(run),
                    _ => {}
                }
                if self.desk.finish(run) {
                    self.desk.compare(run, seed);
                }
                if draw.below(2) == 0 {
                    self.desk.order("delete", run);
                }
            }
            sleep(draw.millis(0, pauses));
        }
    }
}

/// One fault, from its beginning to its end; its name.
fn fault(farm: &mut Farm, draw: &mut Draw, (gentle, longest): (bool, u64)) -> &'static str {
    let other = Role::Worker(1 + draw.below(WORKERS as u64 - 1) as usize);
    let link = draw.below(WORKERS as u64 + 1) as usize;
    let (weather, first) = match farm.links.get(link) {
        Some((weather, _)) => (weather.clone(), link == 0),
        None => (farm.door.0.clone(), false),
    };
    let sleeps = |farm: &mut Farm, role: Role, hold: Duration| {
        signal(farm.post(role).process.id(), "STOP");
        sleep(hold);
        signal(farm.post(role).process.id(), "CONT");
    };
    let hold = draw.millis(longest / 16, longest);
    // A link that is given up under a job thrice costs a worker its place.
    let short = if first { hold.min(Duration::from_secs(3)) } else { hold };
    let kill = |farm: &mut Farm, role: Role| {
        farm.kill(role);
        sleep(hold / 4);
    };
    match draw.below(if gentle { 8 } else { 11 }) {
        0 => (kill(farm, other), "worker killed").1,
        1 => (sleeps(farm, other, hold), "worker stopped").1,
        2 => match other {
            Role::Worker(k) if farm.kill_job(k) => "job process killed",
            _ => "nothing",
        },
        3 => {
            weather.cut();
            "connections cut"
        }
        4 => {
            weather.silent.store(true, Ordering::SeqCst);
            sleep(short);
            (weather.clear(), "blackhole").1
        }
        5 => {
            weather.flips.store(8, Ordering::SeqCst);
            sleep(hold);
            (weather.clear(), "bits turned over").1
        }
        6 => {
            weather.delay.store(20, Ordering::SeqCst);
            weather.rate.store(300_000, Ordering::SeqCst);
            sleep(hold);
            (weather.clear(), "slow link").1
        }
        7 => match draw.below(2) {
            0 => (sleeps(farm, Role::Router, hold), "router stopped").1,
            _ => (sleeps(farm, Role::Coordinator, hold), "coordinator stopped").1,
        },
        8 => (kill(farm, Role::Router), "router killed").1,
        _ => (kill(farm, Role::Coordinator), "coordinator killed").1,
    }
}

/// What processes held in the middle, and what of results was kept on disk \[KiB\].
type Sample = (BTreeMap<u32, Held>, u64);

/// Results that the coordinator keeps on disk \[KiB\].
fn kept(farm: &Farm) -> u64 {
    let files = std::fs::read_dir(farm.folder.join("state/cache")).into_iter().flatten().flatten();
    files.filter_map(|file| Some(file.metadata().ok()?.len())).sum::<u64>() >> 10
}

/// Who was there at the reference and is there still: none holds much more than it did.
fn check_leaks(farm: &Farm, (before, cached): &Sample, said: &mut Vec<String>) {
    let more = (kept(farm).saturating_sub(*cached)).min(256 << 10);
    for post in &farm.posts {
        let id = post.process.id();
        let (Some(old), Some(new)) = (before.get(&id), Held::by(id)) else { continue };
        println!("{:?}: {old:?} then, {new:?} now", post.role);
        // A coordinator keeps up to 256 MiB of results in memory, as many as it keeps on disk.
        let room = if post.role == Role::Coordinator { (64 << 10) + 2 * more } else { 32 << 10 };
        if new.memory > old.memory + room
            || new.files > old.files + 24
            || new.threads > old.threads + 12
        {
            said.push(format!("leak: {:?} held {old:?} and holds {new:?}", post.role));
        }
    }
}

/// Says what everybody holds.
fn held(farm: &Farm, begun: Instant) {
    let all = farm.posts.iter().map(|post| (post.role, Held::by(post.process.id())));
    println!("{} s: {:?}", begun.elapsed().as_secs(), all.collect::<Vec<_>>());
}

/// Faults until the time is over; what each process held in the middle.
fn storm(farm: &mut Farm, draw: &mut Draw, length: Duration) -> Sample {
    let (begun, long) = (Instant::now(), length > LONG);
    let (longest, pause) = if long { (8_000, (1_000, 6_000)) } else { (2_000, (200, 1_000)) };
    let (mut counts, mut before) = (BTreeMap::<_, u64>::new(), Sample::default());
    let mut told = 0;
    while begun.elapsed() < length {
        // After a quarter of an hour's soak router and coordinator stay, and may show that they
        // leak; in a short one there is no time for that.
        let gentle = long && begun.elapsed() > length / 4;
        let name = fault(farm, draw, (gentle, longest));
        *counts.entry(name).or_default() += 1;
        farm.tend();
        sleep(draw.millis(pause.0, pause.1));
        farm.tend();
        let lines = begun.elapsed().as_secs() / 300;
        if lines > told {
            told = lines;
            held(farm, begun);
        }
        if before.0.is_empty() && begun.elapsed() > length / 2 {
            // Who has just begun will hold more.
            let old = farm.posts.iter().filter(|post| post.since.elapsed() > GROWN);
            let ids = old.map(|post| post.process.id());
            before = (ids.filter_map(|id| Some((id, Held::by(id)?))).collect(), kept(farm));
        }
    }
    farm.heal();
    println!("faults: {counts:?}, {} in all", counts.values().sum::<u64>());
    before
}

/// What the logs and the diary say, checked.
fn judge(farm: &Farm, (acts, listed): (&[Act], &[Listed]), said: &mut Vec<String>) {
    for (role, code) in &farm.by_themselves {
        // A worker under which jobs died is sent away; a coordinator that finds no router leaves.
        if !matches!((role, code), (Role::Worker(_), Some(0)) | (Role::Coordinator, Some(69))) {
            said.push(format!("crash: {role:?} ended with {code:?}"));
        }
    }
    let steps = farm.steps();
    said.extend(check_runs(acts, listed));
    said.extend(check_jobs(&steps));
    let count = |heard| acts.iter().filter(|a| a.verb == "submit" && a.heard == heard).count();
    let of = |verb| acts.iter().filter(|a| a.verb == verb).count();
    let settled = steps.iter().filter(|step| matches!(step, Step::Settled { .. })).count();
    println!(
        "{} submissions acknowledged, {} without an answer, {} cancelled, {} deleted, {} runs \
         there in the end; {} grants, {settled} settlements; ended by themselves: {:?}",
        count(Heard::Ok),
        count(Heard::Info),
        of("cancel"),
        of("delete"),
        listed.len(),
        steps.iter().filter(|step| matches!(step, Step::Granted { .. })).count(),
        farm.by_themselves,
    );
}

#[test]
fn a_farm_under_one_fault_after_another_loses_and_doubles_nothing() {
    let length = Duration::from_secs(number("CULLET_SOAK_S", 10));
    let time = std::time::UNIX_EPOCH.elapsed().map_or(0, |since| since.as_nanos() as u64);
    let seed = number("CULLET_SEED", time);
    println!("CULLET_SOAK_S={} CULLET_SEED={seed}", length.as_secs());
    let mut draw = Draw(seed);
    let named = std::env::var_os("CULLET_SOAK_DIR").map(PathBuf::from);
    let folder = named.clone().unwrap_or_else(|| unique("soak"));
    let mut farm = Farm::start(folder.clone(), WORKERS);
    let desk = Desk::open(&farm.door.1, &folder);
    let (over, seeds) = (AtomicBool::new(false), AtomicU64::new(0));
    let all = Arc::new(Clients { desk, over, seeds });
    let pauses = if length > LONG { 6_000 } else { 500 };
    let client = |_| {
        let (all, draw) = (all.clone(), Draw(draw.below(u64::MAX)));
        std::thread::spawn(move || all.come_and_go(draw, pauses))
    };
    let clients: Vec<_> = (0..2).map(client).collect();
    let before = storm(&mut farm, &mut draw, length);
    all.over.store(true, Ordering::SeqCst);
    all.desk.healed();
    let healed = Instant::now();
    clients.into_iter().for_each(|client| client.join().expect("a client"));
    // One that nobody cancels, whatever was drawn.
    let last = all.seeds.fetch_add(1, Ordering::SeqCst) + 1;
    let tries = (0..5).find_map(|_| {
        // One that was begun as the last fault began may have left for it.
        farm.tend();
        all.desk.submit(last, None)
    });
    let run = tries.expect("it is taken");
    assert!(all.desk.finish(run), "run {run} is not done");
    all.desk.compare(run, last);
    let listed = all.desk.listed();
    let (mut said, acts) = all.desk.close();
    println!("all over {:.1} s after healing", healed.elapsed().as_secs_f64());
    check_leaks(&farm, &before, &mut said);
    farm.leave();
    let left = farm.left();
    assert!(left.is_empty(), "processes are left behind: {left:?}");
    judge(&farm, (&acts, &listed), &mut said);
    println!("{} compared with a quiet machine", all.desk.compared());
    assert!(said.is_empty(), "{said:#?}\nin {}", folder.display());
    assert!(all.desk.compared() > 0, "nothing was shown");
    if named.is_none() {
        std::fs::remove_dir_all(folder).ok();
    }
}
