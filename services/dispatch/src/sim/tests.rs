//! Schedules without a fault in the machines, and with one planted on purpose.

use super::check::{Oracle, Wrong};
use super::farm::{shrink, try_plan};
use super::plan::Plan;
use crate::mutant::Mutant;

/// Schedules that every run of the tests goes through.
const SCHEDULES: u64 = 20_000;
/// Schedules within which each planted bug must show.
const MUTANT_SCHEDULES: u64 = 5_000;

/// Each planted bug, and the oracle that is meant for it.
const MUTANTS: [(Mutant, Oracle); 38] = [
    (Mutant::SettleAsTheyCome, Oracle::Order),
    (Mutant::PollMintsTwice, Oracle::Poll),
    (Mutant::NoExpiry, Oracle::Live),
    (Mutant::NoDedupe, Oracle::Once),
    (Mutant::DownTakesAll, Oracle::Healthy),
    (Mutant::NoLimit, Oracle::Poison),
    (Mutant::IncarnationForgotten, Oracle::Epoch),
    (Mutant::AckedBeforeKept, Oracle::Kept),
    (Mutant::CancelSpreads, Oracle::Truth),
    (Mutant::PauseIgnored, Oracle::Pause),
    (Mutant::HedgedAgain, Oracle::Hedge),
    (Mutant::NoAgeing, Oracle::Starved),
    (Mutant::NoBound, Oracle::Bound),
    (Mutant::DeafToStop, Oracle::Stop),
    (Mutant::NoWatchdog, Oracle::Watchdog),
    (Mutant::ResultForgotten, Oracle::Result),
    (Mutant::ForeignTaken, Oracle::Fence),
    (Mutant::AnybodyWill, Oracle::Skill),
    (Mutant::QuarantineForgotten, Oracle::Poison),
    (Mutant::ChargedUnbegun, Oracle::Innocent),
    (Mutant::VanishedUncharged, Oracle::Poison),
    (Mutant::CancelUnsaid, Oracle::Told),
    (Mutant::KeptOfNobody, Oracle::Alarm),
    (Mutant::KillerAgain, Oracle::Spared),
    (Mutant::NeverDrained, Oracle::Drained),
    (Mutant::DoubtUnheeded, Oracle::Doubted),
    (Mutant::BlameStays, Oracle::Drained),
    (Mutant::BlameBySession, Oracle::Spared),
    (Mutant::HedgedAtHome, Oracle::Hedge),
    (Mutant::GhostAwaited, Oracle::Live),
    (Mutant::DrainForgotten, Oracle::Drained),
    (Mutant::InheritedUnawaited, Oracle::Anew),
    (Mutant::InheritedSuperseded, Oracle::Anew),
    (Mutant::InheritedUnknown, Oracle::Anew),
    (Mutant::InheritedKept, Oracle::Stop),
    (Mutant::ClaimantPassedOver, Oracle::Told),
    (Mutant::MakerPassedOver, Oracle::Maker),
    (Mutant::MakerAwaited, Oracle::Idle),
];

fn from_environment(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

fn tell(seed: u64, wrong: &Wrong) -> String {
    let (mild, why) = shrink(&Plan::draw(seed), None, wrong.oracle);
    format!("schedule {seed}: {wrong:?}\nthe mildest that still fails: {mild:?}\n{why:?}")
}

#[test]
fn every_opening_settles_once_and_in_order_through_any_faults() {
    if let Some(seed) = from_environment("CULLET_SEED") {
        if let Err(wrong) = try_plan(&Plan::draw(seed), None) {
            panic!("{}", tell(seed, &wrong));
        }
        return;
    }
    let most = from_environment("CULLET_SCHEDULES").unwrap_or(SCHEDULES);
    let first = from_environment("CULLET_FIRST").unwrap_or(0);
    let mut events = 0;
    for seed in first..first + most {
        match try_plan(&Plan::draw(seed), None) {
            Ok(more) => events += more,
            Err(wrong) => panic!("{}", tell(seed, &wrong)),
        }
    }
    println!("{most} schedules, {events} events");
}

#[test]
fn each_planted_bug_is_caught_by_the_oracle_meant_for_it() {
    let mut table = String::new();
    let mut missed = Vec::new();
    for (mutant, oracle) in MUTANTS {
        let caught = (0..MUTANT_SCHEDULES).find_map(|seed| {
            let wrong = try_plan(&Plan::draw(seed), Some(mutant)).err()?;
            (wrong.oracle == oracle).then_some((seed, wrong))
        });
        match caught {
            Some((seed, wrong)) => {
                let line = format!("| {mutant:?} | {oracle:?} | {} | {} |\n", seed + 1, wrong.text);
                table.push_str(&line);
            }
            None => missed.push((mutant, oracle)),
        }
    }
    println!("{table}");
    assert!(missed.is_empty(), "not caught in {MUTANT_SCHEDULES} schedules: {missed:?}");
}

#[test]
fn a_failing_schedule_is_made_mild() {
    let mutant = Some(Mutant::SettleAsTheyCome);
    let failing = (0..100).map(Plan::draw).filter(|plan| plan.runs.len() > 1).find_map(|plan| {
        let wrong = try_plan(&plan, mutant).err()?;
        Some((plan, wrong.oracle))
    });
    let (plan, oracle) = failing.expect("a schedule that fails");
    let (mild, why) = shrink(&plan, mutant, oracle);
    assert!(why.is_some() && mild.runs.len() == 1, "{mild:#?}");
    assert!(mild.runs[0].jobs.len() <= 4 && mild.chaos == Default::default(), "{mild:#?}");
}
