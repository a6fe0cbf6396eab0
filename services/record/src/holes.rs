//! What is missing in a recording. Each damaged part of its file leaves a hole, which a recovered
//! file remembers; and messages are counted by topic, so that one that is gone is missed.

use super::found::Found;
use super::points::SPECIMEN;
use mcap::records::MessageHeader;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

/// The metadata record that a recovered file has in the place of each damaged part.
pub(super) const HOLE: &str = "cullet.hole";
/// The one that it has for messages that are gone from the ends of topics, with their numbers.
pub(super) const GONE: &str = "cullet.gone";
/// What the types of our own messages begin with.
const OURS: &str = "cullet.";
/// Holes whose steps are told.
const TOLD: usize = 4;
/// Nanoseconds of a second.
const NANOSECONDS: f64 = 1e9;

/// What is missing in a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Holes {
    /// Parts of the file that are damaged, or were before it was recovered.
    pub parts: u64,
    /// Records that are missing, by topic: those before others of the same topic.
    pub records: BTreeMap<String, u64>,
    /// The same of the drawings and numbers for viewers, of all topics.
    pub drawings: u64,
    /// Records that are there, of which the topic is not known.
    pub nameless: u64,
    /// Bodies that move or are made, and whose birth is missing.
    pub unborn: u64,
    /// Between which log times something is missing \[ns\]; of a hole at the end the second is
    /// [`u64::MAX`].
    pub spans: Vec<[u64; 2]>,
    /// Time step of the run \[s\]; 0 where it is not known.
    pub step: f64,
}

impl Holes {
    /// Whether nothing is missing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        let counts = [self.parts, self.drawings, self.nameless, self.unborn];
        counts == [0; 4] && self.records.is_empty()
    }

    /// When something is missing, in steps where their length is known.
    fn tell_span(&self, [from, to]: [u64; 2]) -> String {
        let moment = |time: u64| {
            let time = time as f64 / NANOSECONDS;
            match self.step > 0.0 {
                true => format!("step {:.0}", time / self.step),
                false => format!("{time:.4} s"),
            }
        };
        match to {
            u64::MAX => format!("from {} to the end", moment(from)),
            to => format!("from {} to {}", moment(from), moment(to)),
        }
    }
}

impl fmt::Display for Holes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut told = Vec::new();
        match self.parts {
            0 => {}
            1 => told.push("a part of the file is damaged".to_owned()),
            parts => told.push(format!("{parts} parts of the file are damaged")),
        }
        let records = self.records.iter().map(|(topic, count)| format!("{count} of {topic}"));
        let drawings = (self.drawings > 0).then(|| format!("{} for viewers", self.drawings));
        let records: Vec<String> = records.chain(drawings).collect();
        if !records.is_empty() {
            told.push(format!("records are missing: {}", records.join(", ")));
        }
        if self.nameless > 0 {
            told.push(format!("{} records have lost their topic", self.nameless));
        }
        if self.unborn > 0 {
            told.push(format!("{} bodies are left out, for their births are missing", self.unborn));
        }
        let spans = self.spans.iter().take(TOLD).map(|&span| self.tell_span(span));
        let more = self.spans.len().saturating_sub(TOLD);
        let more = (more > 0).then(|| format!("{more} times more"));
        let spans: Vec<String> = spans.chain(more).collect();
        if !spans.is_empty() {
            told.push(spans.join(", "));
        }
        f.write_str(&told.join("; "))
    }
}

/// A channel of a file.
struct ChannelCount {
    topic: Arc<str>,
    /// Whether its messages are of our own types.
    ours: bool,
    /// The number that its next message has.
    next: u32,
    /// How many of its messages are there.
    seen: u64,
    /// Log time of its last message \[ns\].
    last: u64,
}

/// Finds what is missing in a file while it is walked over, and whether it is of this program.
#[derive(Default)]
pub(super) struct HoleFinder {
    /// Schemas, and whether they are of our own types.
    schemas: BTreeMap<u16, bool>,
    channels: BTreeMap<u16, ChannelCount>,
    /// Whether anything of ours was found.
    pub(super) ours: bool,
    /// The latest log time \[ns\].
    now: u64,
    /// The log time before a hole that has no end yet \[ns\].
    since: Option<u64>,
    /// The shortest time in which a topic misses messages \[ns\].
    shortest: Option<[u64; 2]>,
    holes: Holes,
}

impl HoleFinder {
    /// Takes in what was found next; a message of ours gets its topic.
    pub(super) fn take(&mut self, found: &mut Found) {
        match found {
            Found::Schema(header, _) => {
                let ours = header.name.starts_with(OURS);
                self.schemas.insert(header.id, ours);
                self.ours |= ours;
            }
            Found::Channel(channel) => {
                let ours = self.schemas.get(&channel.schema_id) == Some(&true);
                let topic = Arc::from(&channel.topic[..]);
                let known = self.channels.get(&channel.id);
                let known = known.map(|known| (known.next, known.seen, known.last));
                let (next, seen, last) = known.unwrap_or_default();
                self.channels.insert(channel.id, ChannelCount { topic, ours, next, seen, last });
            }
            Found::Message(header, _, topic) => *topic = self.follow(header),
            Found::Metadata(of) if of.name == "run" => {
                let step = of.metadata.get("step").and_then(|step| step.parse().ok());
                self.holes.step = step.unwrap_or_default();
                self.ours |= of.metadata.contains_key("scene");
            }
            Found::Metadata(of) => self.ours |= of.name == SPECIMEN,
            Found::Hole => {
                self.holes.parts += 1;
                self.since.get_or_insert(self.now);
            }
            Found::Gone(numbers) => {
                for (topic, number) in numbers {
                    let known = self.holes.records.entry(topic.clone()).or_default();
                    *known = known.saturating_add(*number);
                }
            }
            Found::Attachment(..) | Found::ChunkEnd => {}
        }
    }

    /// How many messages are gone from the ends of topics of ours, where a file counts as many on
    /// each channel; nothing where none are.
    pub(super) fn find_gone(&self, counts: &BTreeMap<u16, u64>) -> Option<Found> {
        let gone = |(id, count): (&u16, &u64)| {
            let channel = self.channels.get(id).filter(|channel| channel.ours)?;
            // A recovered file counts those that are in it, whose numbers are beyond that.
            let known = channel.seen.max(u64::from(channel.next));
            let gone = count.checked_sub(known).filter(|gone| *gone > 0)?;
            Some((channel.topic.to_string(), gone))
        };
        let gone: BTreeMap<String, u64> = counts.iter().filter_map(gone).collect();
        (!gone.is_empty()).then_some(Found::Gone(gone))
    }

    /// Whether a schema or a channel was found already.
    pub(super) fn knows(&self, found: &Found) -> bool {
        match found {
            Found::Schema(header, _) => self.schemas.contains_key(&header.id),
            Found::Channel(channel) => self.channels.contains_key(&channel.id),
            _ => false,
        }
    }

    /// Takes in a message, which follows the last one of its channel or misses some; hands back
    /// its topic, if it is of ours.
    fn follow(&mut self, header: &MessageHeader) -> Option<Arc<str>> {
        let time = header.log_time;
        self.holes.spans.extend(self.since.take().map(|since| [since, time]));
        self.now = self.now.max(time);
        let Some(channel) = self.channels.get_mut(&header.channel_id) else {
            self.holes.nameless += 1;
            return None;
        };
        let missing = u64::from(header.sequence.saturating_sub(channel.next));
        if missing > 0 {
            match channel.ours {
                true => {
                    *self.holes.records.entry(channel.topic.to_string()).or_default() += missing;
                }
                false => self.holes.drawings += missing,
            }
            let span = [channel.last, time];
            let length = |[from, to]: [u64; 2]| to.saturating_sub(from);
            let shorter = self.shortest.is_none_or(|known| length(span) < length(known));
            self.shortest = if shorter { Some(span) } else { self.shortest };
        }
        (channel.next, channel.last) = (header.sequence.wrapping_add(1), time);
        channel.seen += 1;
        channel.ours.then(|| channel.topic.clone())
    }

    /// What is missing, once all is walked over.
    pub(super) fn finish(mut self) -> Holes {
        self.holes.spans.extend(self.since.map(|since| [since, u64::MAX]));
        if self.holes.spans.is_empty() {
            // A part is gone without a trace: of a middle one topics miss some, of the last none
            // does.
            let last = (!self.holes.records.is_empty()).then_some([self.now, u64::MAX]);
            self.holes.spans.extend(self.shortest.or(last));
        }
        self.holes
    }
}
