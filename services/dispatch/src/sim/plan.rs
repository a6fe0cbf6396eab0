//! What a schedule does, drawn from its seed; and how to make it milder.

use crate::{Build, Job, Millis, Share, Skills, Tenant, Worker, WorkerName};
use std::collections::BTreeSet;

/// Splitmix64.
#[derive(Clone, Debug)]
pub(super) struct Rng(pub(super) u64);

impl Rng {
    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(super) fn below(&mut self, n: u64) -> u64 {
        self.next() % n.max(1)
    }

    pub(super) fn chance(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }
}

/// How bad a schedule is: percent of messages, steps or jobs, but for the delay.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Chaos {
    pub(super) drop: u64,
    pub(super) twice: u64,
    /// Longest delay of a message \[ms\]: beyond the others' it also reorders.
    pub(super) delay: u64,
    pub(super) crash: u64,
    pub(super) pause: u64,
    pub(super) cut: u64,
    /// Of crashes: nobody hears of it.
    pub(super) silent: u64,
    pub(super) suspect: u64,
    pub(super) poison: u64,
    pub(super) wedge: u64,
    pub(super) sick: u64,
    /// The coordinator dies between two outputs.
    pub(super) fall: u64,
    /// Of solves: they find something else.
    pub(super) flaky: u64,
}

/// How many knobs [`Chaos`] has.
const KNOBS: usize = 13;

impl Chaos {
    fn knob(&mut self, at: usize) -> &mut u64 {
        match at {
            0 => &mut self.drop,
            1 => &mut self.twice,
            2 => &mut self.delay,
            3 => &mut self.crash,
            4 => &mut self.pause,
            5 => &mut self.cut,
            6 => &mut self.silent,
            7 => &mut self.suspect,
            8 => &mut self.poison,
            9 => &mut self.wedge,
            10 => &mut self.sick,
            11 => &mut self.fall,
            _ => &mut self.flaky,
        }
    }
}

/// One run of the plan.
#[derive(Clone, Debug)]
pub(super) struct Script {
    pub(super) share: Share,
    /// When what is opened.
    pub(super) jobs: Vec<(Millis, Job)>,
    /// Whether each job starts from the result of the one before, which is done by then.
    pub(super) chain: bool,
    pub(super) cancel: Option<Millis>,
    pub(super) pause: Option<(Millis, Millis)>,
}

/// A schedule.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) seed: u64,
    pub(super) chaos: Chaos,
    /// What each worker can do; the first can do everything.
    pub(super) workers: Vec<Skills>,
    /// Places whose workers have one name; all others have a name of their own, each anew.
    pub(super) alike: BTreeSet<usize>,
    /// Whether there are workers of two builds, which find different bits for some jobs.
    pub(super) mixed: bool,
    /// Places, never the first, whose workers' every job dies, in chaos and after.
    pub(super) bad: BTreeSet<usize>,
    /// When the workers at which places, never the first, are drained by hand.
    pub(super) drains: Vec<(Millis, usize)>,
    /// Whether jobs ask for different skills.
    pub(super) picky: bool,
    pub(super) runs: Vec<Script>,
    pub(super) poison: BTreeSet<Job>,
    pub(super) wedge: BTreeSet<Job>,
    /// Longest solve \[ms\].
    pub(super) length: u64,
    /// Unsettled openings that a run may have.
    pub(super) max_open: u64,
}

impl Plan {
    pub(super) fn draw(seed: u64) -> Self {
        let mut rng = Rng(seed.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ 0x5bf0_3635);
        let mut pick = |most: u64| if rng.chance(50) { rng.below(most + 1) } else { 0 };
        let chaos = Chaos {
            drop: pick(30),
            twice: pick(30),
            delay: pick(2_500),
            crash: pick(6),
            pause: pick(4),
            cut: pick(3),
            silent: pick(100),
            suspect: pick(3),
            poison: pick(20),
            wedge: pick(10),
            sick: pick(30),
            fall: pick(4),
            flaky: 0,
        };
        // Every eighth is calm: then nothing may be lost at all.
        let chaos = if seed.is_multiple_of(8) { Chaos::default() } else { chaos };
        let mut plan = Self {
            seed,
            chaos,
            workers: vec![Skills::ALL; 1 + rng.below(5) as usize],
            alike: BTreeSet::new(),
            mixed: rng.chance(40),
            bad: BTreeSet::new(),
            drains: Vec::new(),
            picky: rng.chance(30),
            runs: Vec::new(),
            poison: BTreeSet::new(),
            wedge: BTreeSet::new(),
            length: [300, 1_000, 3_000][rng.below(3) as usize],
            max_open: if rng.chance(20) { 3 } else { 1_000 },
        };
        let many = if rng.chance(10) { 40 } else { 12 };
        for _ in 0..1 + rng.below(4) {
            plan.write(&mut rng, many);
        }
        for skills in plan.workers.iter_mut().skip(1).filter(|_| plan.picky) {
            *skills = Skills(rng.below(4));
        }
        if plan.chaos != Chaos::default() && rng.chance(20) {
            plan.chaos.flaky = 5 + rng.below(45);
        }
        if plan.chaos != Chaos::default() && rng.chance(25) {
            plan.bad = (1..plan.workers.len()).filter(|_| rng.chance(50)).collect();
        }
        if plan.workers.len() > 1 && rng.chance(30) {
            let places = plan.workers.len() as u64 - 1;
            let drain = |_| (rng.below(12_000), 1 + rng.below(places) as usize);
            plan.drains = (0..3).map(drain).collect();
        }
        plan.runs.iter_mut().for_each(|run| run.chain = rng.chance(30));
        if plan.workers.len() > 2 && rng.chance(40) {
            let (places, last) = (2 + rng.below(2) as usize, plan.workers.len());
            plan.alike = (last.saturating_sub(places)..last).collect();
        }
        plan
    }

    /// Whether nothing goes wrong.
    pub(super) fn is_calm(&self) -> bool {
        self.chaos == Chaos::default() && self.bad.is_empty()
    }

    /// What a job asks of a worker.
    pub(super) fn need(&self, job: Job) -> Skills {
        Skills(if self.picky { u64::from(job.0[1] % 4) } else { 0 })
    }

    /// What a worker at this place is called.
    pub(super) fn name(&self, worker: Worker, place: usize) -> WorkerName {
        WorkerName(if self.alike.contains(&place) { 1 } else { worker.0 })
    }

    /// What a worker runs.
    pub(super) fn build(&self, worker: Worker) -> Build {
        Build([if self.mixed { worker.0 as u8 % 2 } else { 0 }; 32])
    }

    fn write(&mut self, rng: &mut Rng, many: u64) {
        let tenant = Tenant(rng.below(2));
        let priority = if rng.chance(50) { rng.below(10) as u8 } else { Share::NORMAL };
        let known: Vec<Job> = self.runs.iter().flat_map(|run| &run.jobs).map(|(_, j)| *j).collect();
        let spread = if rng.chance(50) { 1 } else { 4_000 };
        let (mut jobs, mut at) = (Vec::new(), rng.below(2_000));
        for _ in 0..1 + rng.below(many) {
            at += rng.below(spread) / 4;
            let again = !known.is_empty() && rng.chance(15);
            let job = if again {
                known[rng.below(known.len() as u64) as usize]
            } else {
                let mut name = [0; 32];
                name[..8].copy_from_slice(&rng.next().to_le_bytes());
                Job(name)
            };
            if rng.chance(self.chaos.poison) {
                self.poison.insert(job);
            } else if rng.chance(self.chaos.wedge) {
                self.wedge.insert(job);
            }
            jobs.push((at, job));
        }
        let cancel = rng.chance(15).then(|| rng.below(8_000));
        let pause = rng.chance(20).then(|| {
            let from = rng.below(4_000);
            (from, from + rng.below(8_000))
        });
        let (share, chain) = (Share { tenant, priority }, false);
        self.runs.push(Script { share, jobs, chain, cancel, pause });
    }

    /// Every plan that is a step milder.
    pub(super) fn milder(&self) -> Vec<Self> {
        let mut all = vec![Self { chaos: Chaos::default(), ..self.clone() }];
        for run in 0..self.runs.len() {
            let mut less = self.clone();
            less.runs.remove(run);
            all.push(less);
            let jobs = self.runs[run].jobs.len();
            let mut less = self.clone();
            less.runs[run].jobs.truncate(jobs / 2);
            all.push(less);
            for at in (0..jobs).rev() {
                let mut less = self.clone();
                less.runs[run].jobs.remove(at);
                all.push(less);
            }
            let mut less = self.clone();
            (less.runs[run].cancel, less.runs[run].pause) = (None, None);
            all.push(less);
            let mut less = self.clone();
            less.runs[run].chain = false;
            all.push(less);
        }
        for knob in 0..KNOBS {
            let mut less = self.clone();
            *less.chaos.knob(knob) = 0;
            all.push(less);
        }
        for which in 0..6 {
            let mut less = self.clone();
            match which {
                0 => less.workers.truncate((self.workers.len() - 1).max(1)),
                1 => less.mixed = false,
                2 => drop(less.bad.pop_last()),
                3 => drop(less.drains.pop()),
                4 => drop(less.alike.pop_last()),
                _ => less.picky = false,
            }
            all.push(less);
        }
        all.retain(|less| !less.runs.is_empty() && less.size() < self.size());
        all.retain(|less| less.runs.iter().all(|run| !run.jobs.is_empty()));
        all
    }

    /// Something that falls with every step to a milder plan.
    fn size(&self) -> u64 {
        let mut chaos = self.chaos;
        let knobs = (0..KNOBS).filter(|k| *chaos.knob(*k) > 0).count() as u64;
        let jobs: usize = self.runs.iter().map(|run| run.jobs.len()).sum();
        let extras = |s: &Script| [s.cancel.is_some(), s.pause.is_some(), s.chain];
        let extras: u64 = self.runs.iter().flat_map(extras).map(u64::from).sum();
        let kinds = u64::from(self.mixed) + u64::from(self.picky);
        kinds
            + self.bad.len() as u64
            + self.drains.len() as u64
            + self.alike.len() as u64
            + knobs
            + self.workers.len() as u64
            + self.runs.len() as u64
            + jobs as u64
            + extras
    }
}
