//! Random schedules of faults under the machine, watched by an oracle of its own.

mod oracle;

use crate::mutant::Mutant;
use crate::*;
use oracle::{Oracle, result_of};
use std::collections::{BTreeMap, BTreeSet};

/// Schedules a run of the tests goes through.
const SCHEDULES: u64 = 6_000;
/// Schedules within which each planted bug must show.
const MUTANT_SCHEDULES: u64 = 1_000;
/// Faults end here \[ms\].
const HEAL: Millis = 15_000;
/// Everything is settled by then \[ms\].
const END: Millis = 400_000;
/// A worker repeats an unanswered question after this \[ms\].
const RETRY: Millis = 250;

const RUN: Run = Run(1);

struct Rng(u64);

impl Rng {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    fn below(&mut self, n: u64) -> u64 {
        self.next() % n.max(1)
    }
    fn chance(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }
}

/// How bad a schedule is \[percent\].
#[derive(Clone, Copy, Default)]
struct Chaos {
    drop: u64,
    twice: u64,
    delay: u64,
    crash: u64,
    pause: u64,
    silent: u64,
    poison: u64,
}

#[derive(Clone, Copy, Debug)]
enum Note {
    Heard(Event),
    Told(Effect),
    Wake(Worker),
    Born,
    Tick,
}

#[derive(Clone, Copy, PartialEq)]
enum Doing {
    Ask,
    Work { job: Job, epoch: Epoch, until: Millis },
    Hand { job: Job, epoch: Epoch },
    Dead,
}

struct Hand {
    seq: u64,
    doing: Doing,
    frozen: Millis,
}

struct Sim {
    rng: Rng,
    chaos: Chaos,
    now: Millis,
    notes: BTreeMap<(Millis, u64), Note>,
    posted: u64,
    machine: Dispatch,
    hands: BTreeMap<Worker, Hand>,
    oracle: Oracle,
    poison: BTreeSet<Job>,
    timing: Timing,
}

impl Sim {
    fn new(seed: u64, mutant: Option<Mutant>) -> Self {
        let mut rng = Rng(seed.wrapping_mul(0x2545_f491_4f6c_dd1d));
        let mut pick = |most: u64| {
            if rng.chance(60) { rng.below(most + 1) } else { 0 }
        };
        let chaos = match seed % 8 {
            0 => Chaos::default(),
            _ => Chaos {
                drop: pick(30),
                twice: pick(30),
                delay: pick(2_500),
                crash: pick(40),
                pause: pick(20),
                silent: pick(100),
                poison: pick(20),
            },
        };
        let timing = Timing::test();
        let mut machine = Dispatch::new(timing, 1);
        machine.mutant = mutant;
        machine.step(0, Event::Begin { run: RUN, share: Share::default() });
        let mut sim = Self {
            rng,
            chaos,
            now: 0,
            notes: BTreeMap::new(),
            posted: 0,
            machine,
            hands: BTreeMap::new(),
            oracle: Oracle::default(),
            poison: BTreeSet::new(),
            timing,
        };
        for _ in 0..1 + sim.rng.below(4) {
            sim.post(0, Note::Born);
        }
        for index in 0..1 + sim.rng.below(20) {
            let mut name = [0; 32];
            name[..8].copy_from_slice(&sim.rng.next().to_le_bytes());
            let job = Job(name);
            if index > 0 && sim.rng.chance(sim.chaos.poison) {
                sim.poison.insert(job);
            }
            let at = sim.rng.below(4_000);
            sim.post(at, Note::Heard(Event::Open { run: RUN, job }));
            if sim.rng.chance(10) {
                let again = at + sim.rng.below(4_000);
                sim.post(again, Note::Heard(Event::Open { run: RUN, job }));
            }
        }
        sim.post(0, Note::Tick);
        sim
    }

    fn bad(&mut self, percent: u64) -> bool {
        self.now < HEAL && self.rng.chance(percent)
    }

    fn post(&mut self, after: Millis, note: Note) {
        self.posted += 1;
        self.notes.insert((self.now + after, self.posted), note);
    }

    /// Over the network: lost, copied, late.
    fn send(&mut self, note: Note) {
        let copies = 1 + u64::from(self.bad(self.chaos.twice));
        for _ in 0..copies {
            if !self.bad(self.chaos.drop) {
                let late = if self.now < HEAL { self.chaos.delay } else { 0 };
                let after = 1 + self.rng.below(late + 3);
                self.post(after, note);
            }
        }
    }

    fn run(&mut self) -> Result<(), String> {
        while let Some((&key, _)) = self.notes.first_key_value() {
            let Some(note) = self.notes.remove(&key) else {
                break;
            };
            self.now = key.0;
            if self.now > END {
                return Err(format!("{} of {} settled at the end", self.oracle.settled, {
                    self.oracle.opened.len()
                }));
            }
            self.take(note)?;
            let all = self.now > HEAL && self.oracle.settled == self.oracle.opened.len() as u64;
            if all {
                break;
            }
        }
        let calm = self.chaos.drop + self.chaos.delay + self.chaos.crash + self.chaos.pause == 0
            && self.poison.is_empty();
        if calm && self.oracle.requeued > 0 {
            return Err("a healthy lease was revoked".into());
        }
        Ok(())
    }

    fn take(&mut self, note: Note) -> Result<(), String> {
        match note {
            Note::Heard(event) => self.hear(event)?,
            Note::Tick => {
                self.hear(Event::Tick)?;
                self.post(50, Note::Tick);
            }
            Note::Born => {
                let worker = Worker(self.rng.next());
                self.hands.insert(worker, Hand { seq: 1, doing: Doing::Ask, frozen: 0 });
                self.wake(worker);
            }
            Note::Wake(worker) => self.wake(worker),
            Note::Told(effect) => self.told(effect),
        }
        Ok(())
    }

    fn hear(&mut self, event: Event) -> Result<(), String> {
        if let Event::Open { job, .. } = event {
            self.oracle.open(job);
        }
        for effect in self.machine.step(self.now, event) {
            self.oracle.watch(event, effect, &self.timing)?;
            self.send(Note::Told(effect));
        }
        Ok(())
    }

    fn crash(&mut self, worker: Worker) {
        let Some(hand) = self.hands.get_mut(&worker) else {
            return;
        };
        if hand.doing == Doing::Dead {
            return;
        }
        hand.doing = Doing::Dead;
        if !self.rng.chance(self.chaos.silent) {
            let after = 1 + self.rng.below(self.chaos.delay + 1);
            let sure = self.rng.chance(50);
            let event = if sure { Event::Down(worker) } else { Event::Suspect(worker) };
            self.post(after, Note::Heard(event));
        }
        let after = 100 + self.rng.below(1_000);
        self.post(after, Note::Born);
    }

    fn wake(&mut self, worker: Worker) {
        let (crash, pause) = (self.bad(self.chaos.crash) && self.rng.chance(10), {
            let frozen = self.bad(self.chaos.pause) && self.rng.chance(20);
            if frozen { self.rng.below(5_000) } else { 0 }
        });
        if crash {
            return self.crash(worker);
        }
        let now = self.now;
        let Some(hand) = self.hands.get_mut(&worker) else {
            return;
        };
        hand.frozen = hand.frozen.max(now + pause);
        if hand.frozen > now {
            let after = hand.frozen - now;
            return self.post(after, Note::Wake(worker));
        }
        if let Doing::Work { job, epoch, until } = hand.doing
            && now >= until
        {
            if self.poison.contains(&job) {
                return self.crash(worker);
            }
            hand.doing = Doing::Hand { job, epoch };
        }
        let (event, after) = match hand.doing {
            Doing::Ask => (Event::Poll { worker, seq: hand.seq, slots: 1, park: true }, RETRY),
            Doing::Work { job, epoch, until } => {
                let after = self.timing.renew.min(until - now).max(1);
                (Event::Renew { worker, job, epoch }, after)
            }
            Doing::Hand { job, epoch } => {
                let (digest, outcome) = (result_of(job), Outcome::Broken);
                (Event::Commit { worker, job, epoch, digest, outcome }, RETRY)
            }
            Doing::Dead => return,
        };
        self.send(Note::Heard(event));
        self.post(after, Note::Wake(worker));
    }

    fn told(&mut self, effect: Effect) {
        let length = 50 + self.rng.below(3_000);
        let now = self.now;
        let (worker, next) = match effect {
            Effect::Grant { worker, seq, job, epoch, .. } => {
                let Some(hand) = self.hands.get(&worker) else {
                    return;
                };
                if hand.doing != Doing::Ask || hand.seq != seq {
                    return;
                }
                (worker, Doing::Work { job, epoch, until: now + length })
            }
            Effect::Idle { worker, seq } => {
                let Some(hand) = self.hands.get(&worker) else {
                    return;
                };
                if hand.doing != Doing::Ask || hand.seq != seq {
                    return;
                }
                (worker, Doing::Ask)
            }
            Effect::Stop { worker, job, .. } => match self.hands.get(&worker).map(|h| h.doing) {
                Some(Doing::Work { job: at, .. }) if at == job => (worker, Doing::Ask),
                Some(_) | None => return,
            },
            Effect::Taken { worker, receipt } if receipt != Receipt::Noted => {
                match self.hands.get(&worker).map(|h| h.doing) {
                    Some(Doing::Hand { .. }) => (worker, Doing::Ask),
                    Some(_) | None => return,
                }
            }
            Effect::Taken { .. }
            | Effect::Park { .. }
            | Effect::Renewed { .. }
            | Effect::Lost { .. }
            | Effect::Dismiss { .. }
            | Effect::Drained { .. }
            | Effect::Busy { .. }
            | Effect::Quarantine { .. }
            | Effect::Stall { .. }
            | Effect::Alarm { .. }
            | Effect::Settle { .. } => return,
        };
        if let Some(hand) = self.hands.get_mut(&worker) {
            hand.doing = next;
            hand.seq += u64::from(next == Doing::Ask);
        }
    }
}

#[test]
fn every_opening_settles_once_and_in_order_through_any_faults() {
    for seed in 0..SCHEDULES {
        if let Err(what) = Sim::new(seed, None).run() {
            panic!("schedule {seed}: {what}");
        }
    }
}

#[test]
fn the_oracle_catches_every_planted_bug() {
    for mutant in [
        Mutant::SettleAsTheyCome,
        Mutant::PollMintsTwice,
        Mutant::NoExpiry,
        Mutant::NoDedupe,
        Mutant::DownTakesAll,
        Mutant::NoLimit,
    ] {
        let caught =
            (0..MUTANT_SCHEDULES).find(|&seed| Sim::new(seed, Some(mutant)).run().is_err());
        assert!(caught.is_some(), "{mutant:?} was not caught in {MUTANT_SCHEDULES} schedules");
    }
}
