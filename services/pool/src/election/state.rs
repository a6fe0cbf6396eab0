//! What a coordinator knows of others of its name, and what follows: no I/O.

use cullet_proto::SessionId;
use cullet_proto::claim::{Claim, Reply};
use std::collections::BTreeMap;
use std::fmt;
use std::time::{Duration, Instant, UNIX_EPOCH};

/// Before another is asked again: while one begins, and later.
pub(super) const AGAIN: [Duration; 2] = [Duration::from_millis(100), Duration::from_secs(1)];

/// Another coordinator of the same name, beside which this one does not stay.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Conflict {
    /// The name of both.
    pub name: String,
    /// Who it is; `None`: it does not answer.
    pub claim: Option<Claim>,
    /// Whether this one had begun to serve.
    pub late: bool,
}

impl fmt::Display for Conflict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, claim, late } = self;
        match claim {
            Some(Claim { process, host, since_ms, version, .. }) => {
                // Of another process, which may say anything.
                let [host, version] = [host, version]
                    .map(|text| text.chars().filter(char::is_ascii_graphic).collect::<String>());
                let host = if host.is_empty() { "a machine without a name" } else { &host };
                let since = moment(*since_ms);
                write!(
                    f,
                    "another coordinator is called {name} on this network: process {process} on \
                     {host}, there since {since} (version {version})"
                )?;
            }
            None => write!(
                f,
                "another coordinator is called {name} on this network, and does not answer"
            )?,
        }
        f.write_str(if *late {
            "; it was there first, so this one leaves: what it has accepted is in its state folder \
             and goes on when it is started again where no other has its name"
        } else {
            "; end that one, or give this one a name (--name) or a router of its own"
        })
    }
}

impl std::error::Error for Conflict {}

/// A time as people write it; of another process, which may say anything.
fn moment(unix_ms: u64) -> String {
    let since = Duration::from_secs((unix_ms / 1000).min(LAST));
    let time = humantime::format_rfc3339_seconds(UNIX_EPOCH + since).to_string();
    time.replace('T', " ").replace('Z', " UTC")
}

/// The last second of the year 9999 \[s since 1970\].
const LAST: u64 = 253_402_300_799;

/// Another whose sign of life is seen.
#[derive(Debug)]
struct Other {
    since: Instant,
    /// When to ask it.
    ask: Instant,
    /// It goes, as it has said or was asked to.
    yields: bool,
}

/// What one coordinator knows of the others.
#[derive(Debug)]
pub(super) struct ElectionState {
    name: String,
    pub(super) own: Claim,
    others: BTreeMap<SessionId, Other>,
    /// Whether the first look is over.
    pub(super) looked: bool,
    pub(super) lost: Option<Conflict>,
    /// How long one that begins waits for an answer.
    patience: Duration,
}

impl ElectionState {
    pub(super) fn new(name: String, own: Claim, patience: Duration) -> Self {
        Self { name, own, others: BTreeMap::new(), looked: false, lost: None, patience }
    }

    /// Another's sign of life is seen, or gone.
    pub(super) fn sign(&mut self, life: SessionId, up: bool, now: Instant) {
        if !up {
            self.others.remove(&life);
        } else if life != self.own.life {
            self.others.entry(life).or_insert(Other { since: now, ask: now, yields: false });
        }
    }

    /// Another tells its claim: what it is told. One that goes itself is in nobody's way.
    pub(super) fn asked(&mut self, theirs: &Claim) -> Reply {
        let stays = self.lost.is_none() && self.own.stays_beside(theirs);
        if !stays {
            self.lose(Some(theirs.clone()));
        } else if let Some(other) = self.others.get_mut(&theirs.life) {
            other.yields = true;
        }
        Reply { claim: self.own.clone(), stays }
    }

    /// Another has answered.
    pub(super) fn take_reply(&mut self, reply: Reply) {
        if reply.stays {
            self.lose(Some(reply.claim));
        } else if let Some(other) = self.others.get_mut(&reply.claim.life) {
            other.yields = true;
        }
    }

    fn lose(&mut self, claim: Option<Claim>) {
        let (name, late) = (self.name.clone(), self.own.settled);
        self.lost.get_or_insert(Conflict { name, claim, late });
    }

    /// Time has passed: whom to ask now.
    pub(super) fn tick(&mut self, now: Instant) -> Vec<SessionId> {
        let mut asks = Vec::new();
        let again = AGAIN[usize::from(self.own.settled)];
        for (life, other) in &mut self.others {
            if other.ask <= now {
                other.ask = now + again;
                asks.push(*life);
            }
        }
        let mut open = self.others.values().filter(|other| !other.yields).peekable();
        let clear = open.peek().is_none();
        let mute = open.any(|other| now.duration_since(other.since) > self.patience);
        if !self.own.settled && mute {
            self.lose(None);
        }
        self.own.settled |= self.looked && clear && self.lost.is_none();
        asks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn election(life: u64, since_ms: u64) -> ElectionState {
        let own = Claim { life: SessionId(life), since_ms, process: 7, ..Claim::default() };
        ElectionState::new("main".into(), own, Duration::from_secs(9))
    }

    /// One asks the other, once each sees the other's sign.
    fn meet(one: &mut ElectionState, other: &mut ElectionState, now: Instant) {
        one.sign(other.own.life, true, now);
        if one.tick(now).contains(&other.own.life) {
            let reply = other.asked(&one.own);
            one.take_reply(reply);
        }
    }

    #[test]
    fn of_two_that_begin_together_one_stays_whoever_asks_and_looks_first() {
        // Who asks first, who has looked before, whether the other's sign is seen before the look
        // is over.
        for turn in 0..8 {
            let now = Instant::now();
            let (mut a, mut b) = (election(2, 5), election(1, 6));
            let (one, other) = if turn % 2 == 0 { (&mut a, &mut b) } else { (&mut b, &mut a) };
            if turn & 2 == 0 {
                // Nobody is there at its first look: it serves from then on.
                one.looked = true;
                one.tick(now);
            } else {
                one.sign(other.own.life, true, now);
                one.looked = true;
                one.tick(now);
                assert!(!one.own.settled, "it serves before the other has answered");
            }
            other.looked = turn & 4 == 0;
            meet(other, one, now);
            other.looked = true;
            let later = now + AGAIN[1] * 2;
            meet(one, other, later);
            for who in [&mut *one, &mut *other] {
                who.tick(later);
            }
            assert_eq!(u32::from(a.lost.is_some()) + u32::from(b.lost.is_some()), 1, "turn {turn}");
            assert!(a.own.settled != b.own.settled, "turn {turn}: {a:?} {b:?}");
            assert!(a.lost.is_some() != a.own.settled, "turn {turn}: {a:?}");
        }
    }

    #[test]
    fn two_that_serve_and_find_each_other_agree_who_was_first() {
        for turn in 0..2 {
            let now = Instant::now();
            let (mut first, mut second) = (election(9, 5), election(1, 6));
            for one in [&mut first, &mut second] {
                one.looked = true;
                one.tick(now);
                assert!(one.own.settled);
            }
            if turn == 0 {
                meet(&mut first, &mut second, now);
            } else {
                meet(&mut second, &mut first, now);
            }
            assert!(
                first.lost.is_none() && second.lost.as_ref().is_some_and(|conflict| conflict.late)
            );
            let told = second.lost.map(|conflict| conflict.to_string()).unwrap_or_default();
            assert!(told.contains("process 7") && told.contains("it was there first"), "{told}");
        }
    }

    #[test]
    fn a_sign_without_an_answer_is_waited_for_until_it_is_gone_and_refuses_if_it_stays() {
        let (now, other) = (Instant::now(), SessionId(4));
        let later = now + Duration::from_secs(8);
        let mut one = election(1, 5);
        one.looked = true;
        one.sign(other, true, now);
        assert_eq!(one.tick(now), [other]);
        assert_eq!((one.tick(now), one.tick(now + AGAIN[0])), (vec![], vec![other]));
        one.tick(later);
        assert!(!one.own.settled && one.lost.is_none());
        // Its link was given up: it was one that had been killed.
        one.sign(other, false, later);
        one.tick(later);
        assert!(one.own.settled && one.lost.is_none());
        // One that stays is somebody; but who serves already lets it be.
        one.sign(other, true, later);
        one.tick(later + Duration::from_secs(60));
        assert!(one.lost.is_none());
        let mut two = election(2, 6);
        two.looked = true;
        two.sign(other, true, now);
        two.tick(now + Duration::from_secs(10));
        let told = two.lost.map(|conflict| conflict.to_string()).unwrap_or_default();
        assert!(told.contains("does not answer"), "{told}");
        let claim = Some(Claim { host: "a\u{1b}[2J\n".into(), ..Claim::default() });
        let told = Conflict { name: "main".into(), claim, late: false }.to_string();
        assert!(told.contains("process 0 on a[2J, there"), "{told}");
    }

    #[test]
    fn times_are_those_of_the_calendar() {
        assert_eq!(moment(0), "1970-01-01 00:00:00 UTC");
        assert_eq!(moment(951_782_400_000), "2000-02-29 00:00:00 UTC");
        assert_eq!(moment(1_795_341_801_649), "2026-11-22 10:03:21 UTC");
        assert_eq!(moment(u64::MAX), "9999-12-31 23:59:59 UTC");
    }
}
