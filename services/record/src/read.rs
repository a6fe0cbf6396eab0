//! Reading recordings, whole or cut off: every intact chunk counts, nothing else does.

use super::end::{End, EndStep, has_end};
use super::found::Found;
use super::grains::{GrainRows, LongForm};
use super::holes::{HoleFinder, Holes};
use super::meta::{InteriorLook, interiors};
use super::points::SPECIMEN;
use super::raw_records::{RECORD_HEADER, content, read_with};
use super::sheet_census::SheetCensus;
use super::summary::decode;
use super::{
    APPEARANCE, BODIES, BODY, CRACKS, DEBRIS, EVENTS, GEOMETRY, JOBS, JOINTS, POOL, RecordError,
    SAMPLED, SHAPE, SHEET_SURFACE, SHEETS, Summary, Tally, WINDOWS,
};
use cullet_model::FragmentOrigin;
use cullet_proto::recording::{
    Appearance, Body, BodyJoint, BodyPoses, Cracks, EventKind, Geometry, Grains, JobReport,
    NewShape, PoolReport, Recorded, RunEvent, Sampled, SheetFrame, SheetSurface, SheetWindow,
};
use mcap::records::Record;
use mcap::sans_io::{LinearReader, LinearReaderOptions};
use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::path::{Path, PathBuf};

/// Bytes to which a file unpacks at most, all its chunks together, whatever its size \[bytes\].
/// What repeats itself most are drawings, of which a run has 0.2 GB at most.
const UNPACKED_LEAST: u64 = 1 << 29;
/// How many bytes more for each byte of the file \[1\].
const UNPACKED_TIMES: u64 = 64;
/// Bytes to which a chunk unpacks at most \[bytes\]. Ours have 8 MiB plus one message; a damaged
/// length must not ask for all memory.
const MAX_CHUNK_BYTES: u64 = UNPACKED_LEAST;

/// What a walk over a file came across beside its content.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Walk {
    /// True if the file ends as a finished file does.
    pub(super) ended: bool,
    /// Whole, intact chunks.
    pub(super) chunks: u64,
    /// Chunks that are there but damaged.
    pub(super) damaged: u64,
    /// Bytes at the end that are part of no whole record.
    pub(super) lost_bytes: u64,
    /// What is missing.
    pub(super) holes: Holes,
}

/// Reads a file, or the partial file of a run that never got its name.
pub(super) fn load(path: &Path) -> Result<(PathBuf, Vec<u8>), RecordError> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".partial");
    let partial = path.with_file_name(name);
    let path = if !path.exists() && partial.exists() { partial } else { path.to_owned() };
    let bytes = cullet_files::regular::read(&path).map_err(RecordError::io(&path))?;
    Ok((path, bytes))
}

/// Walks over the records of the data section and hands each piece of content to `found`.
/// Damage ends the walk or skips a chunk; it is never an error.
///
/// # Errors
/// No MCAP file, one of another program, one of ours that is damaged everywhere, or one that
/// unpacks to more than is read; and what `found` says.
pub(super) fn walk(
    path: &Path,
    bytes: &[u8],
    found: &mut dyn FnMut(Found) -> Result<(), RecordError>,
) -> Result<Walk, RecordError> {
    if !bytes.starts_with(mcap::MAGIC) {
        return Err(RecordError::NotMcap { path: path.to_owned() });
    }
    let bound = UNPACKED_LEAST + UNPACKED_TIMES * bytes.len() as u64;
    let (mut walk, mut unpacked) = (Walk::default(), 0_u64);
    let (end, finder) = (End::of(bytes), HoleFinder::default());
    let mut teller = Teller { end, found, finder, some: false, damaged: 0 };
    let (mut at, data_end) = (mcap::MAGIC.len(), teller.end.data_end());
    while let Some(step) = teller.end.step(bytes, at).filter(|_| !walk.ended) {
        let (opcode, whole) = match step {
            EndStep::Record(opcode, end) => (opcode, &bytes[at..end]),
            EndStep::Damaged(next) => {
                at = next;
                walk.ended = Some(next) == data_end;
                teller.tell_damage()?;
                continue;
            }
        };
        at += whole.len();
        match mcap::parse_record(opcode, &whole[RECORD_HEADER..]) {
            Ok(Record::Chunk { header, .. }) => {
                let size = header.uncompressed_size;
                // A length beyond that of any chunk is a damaged one, and nothing is unpacked.
                if size <= MAX_CHUNK_BYTES {
                    unpacked += size;
                }
                if unpacked > bound {
                    return Err(RecordError::Swollen { path: path.to_owned(), bound });
                }
                let Some(content) = unpack(whole) else {
                    teller.tell_damage()?;
                    continue;
                };
                walk.chunks += 1;
                content.into_iter().try_for_each(|item| teller.tell(item))?;
                teller.tell(Found::ChunkEnd)?;
            }
            Ok(Record::DataEnd(_)) => {
                walk.ended = has_end(bytes);
                at = bytes.len();
            }
            Ok(record) => content(record).map_or(Ok(()), |item| teller.tell(item))?,
            Err(_) => teller.tell_damage()?,
        }
    }
    if has_end(bytes) && !walk.ended {
        // A damaged length led astray, and nothing says where it goes on.
        teller.tell_damage()?;
    }
    teller.tell_gone()?;
    walk.lost_bytes = if walk.ended { 0 } else { (bytes.len() - at) as u64 };
    teller.finish(path, walk)
}

/// Hands on what is found in a file.
struct Teller<'a> {
    end: End,
    found: &'a mut dyn FnMut(Found) -> Result<(), RecordError>,
    finder: HoleFinder,
    /// Whether anything was found.
    some: bool,
    /// Parts that are damaged.
    damaged: u64,
}

impl Teller<'_> {
    fn tell(&mut self, mut item: Found) -> Result<(), RecordError> {
        self.some = true;
        self.finder.take(&mut item);
        (self.found)(item)
    }

    /// Tells of a damaged part, and at the first of the channels that it may have declared: the
    /// file has them again at its end.
    fn tell_damage(&mut self) -> Result<(), RecordError> {
        self.damaged += 1;
        self.tell(Found::Hole)?;
        self.tell_channels()
    }

    /// Tells of the schemas and channels of which only the end of the file tells.
    fn tell_channels(&mut self) -> Result<(), RecordError> {
        for item in std::mem::take(&mut self.end.channels) {
            if !self.finder.knows(&item) {
                self.tell(item)?;
            }
        }
        Ok(())
    }

    /// Tells, once all else is told, of messages that no later one misses.
    fn tell_gone(&mut self) -> Result<(), RecordError> {
        let Some(counts) = self.end.counts.take() else { return Ok(()) };
        self.tell_channels()?;
        let gone = self.finder.find_gone(&counts);
        gone.map_or(Ok(()), |gone| self.tell(gone))
    }
    /// The walk with what is missing.
    fn finish(self, path: &Path, walk: Walk) -> Result<Walk, RecordError> {
        let Self { finder, some, damaged, .. } = self;
        // Of one that was cut off at its very beginning nothing is known.
        if !finder.ours && (some || walk.ended) {
            let path = path.to_owned();
            return Err(match damaged {
                0 => RecordError::Foreign { path },
                damaged => RecordError::Lost { path, damaged },
            });
        }
        Ok(Walk { damaged, holes: finder.finish(), ..walk })
    }
}

/// The content of a chunk if all of it is intact. `record` is the whole record, opcode included.
/// The check sum is verified before anything inside is believed: a damaged length would otherwise
/// ask for more memory than there is.
fn unpack(record: &[u8]) -> Option<Vec<Found>> {
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(usize::try_from(MAX_CHUNK_BYTES).unwrap_or(usize::MAX));
    let mut unpacked = Vec::new();
    read_with(LinearReader::new_with_options(options), record, &mut |opcode, data| {
        unpacked.extend(content(mcap::parse_record(opcode, data).ok()?));
        Some(())
    })?;
    Some(unpacked)
}

/// A recording in memory: everything of ours in it, decoded.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// The file that was read: the partial one where the run never finished.
    pub path: PathBuf,
    /// True if the run ended and the file is whole.
    pub complete: bool,
    /// The metadata record `run`.
    pub meta: BTreeMap<String, String>,
    /// The metadata record `end`; empty for a run that was cut off.
    pub end: BTreeMap<String, String>,
    /// Attachments by name.
    pub attachments: BTreeMap<String, Vec<u8>>,
    /// Solids by digest.
    pub geometries: BTreeMap<Vec<u8>, Geometry>,
    /// Bodies in order of birth.
    pub bodies: Vec<Body>,
    /// New shapes of bodies, in the order in which they got them.
    pub shapes: Vec<NewShape>,
    /// The pose track.
    pub poses: Vec<BodyPoses>,
    /// Grains of debris, with a row of each that is new or moved, to the last bit.
    pub debris: Vec<Grains>,
    /// Cracks that end inside bodies.
    pub cracks: Vec<Cracks>,
    /// Joints, in the order in which they were made.
    pub joints: Vec<BodyJoint>,
    /// What happened, in order.
    pub events: Vec<RunEvent>,
    /// How jobs came out.
    pub reports: Vec<JobReport>,
    /// Who answered jobs, windows counted, and which results were there already.
    pub pool: Vec<PoolReport>,
    /// Which fragments were sampled; of an old recording nothing.
    pub sampled: Vec<Sampled>,
    /// What bodies look like, beside their shapes.
    pub appearances: Vec<Appearance>,
    /// Surfaces of sheets by digest.
    pub surfaces: BTreeMap<Vec<u8>, SheetSurface>,
    /// Where the points of sheets are, in the order in which they were told.
    pub sheet_frames: Vec<SheetFrame>,
    /// What came of the windows of sheets, likewise.
    pub windows: Vec<SheetWindow>,
    /// Bytes at the end of the file that were part of no whole record.
    pub lost_bytes: u64,
    /// What is missing in it: nothing in one that is sound, or that only ends early.
    pub holes: Holes,
    /// True if something is missing in it, or its end is though it has the name of a whole file.
    pub damaged: bool,
    tally: Tally,
    rows: GrainRows,
}

impl Recording {
    /// Reads `path`, or `<path>.partial` where only that exists. A file that was cut off reads up
    /// to its last whole chunk. One with holes holds none of the run's expectations: what they were
    /// judged by is not all there.
    ///
    /// # Errors
    /// No such file, no MCAP file, one of another program, one that unpacks to more than is read,
    /// or an intact chunk whose messages are not ours.
    pub fn open(path: &Path) -> Result<Self, RecordError> {
        let (path, bytes) = load(path)?;
        let mut recording = Self { path: path.clone(), ..Self::default() };
        let walk = walk(&path, &bytes, &mut |found| recording.take(found))?;
        let growing = path.extension().is_some_and(|end| end == "partial");
        recording.holes = Holes { unborn: recording.count_unborn(), ..walk.holes };
        let whole = recording.holes.is_empty();
        if !whole {
            recording.events.retain(|event| event.kind() != EventKind::Expectation);
        }
        recording.damaged = !whole || !walk.ended && !growing;
        recording.complete = walk.ended && whole && recording.end.contains_key("wall_seconds");
        recording.lost_bytes = walk.lost_bytes;
        Ok(recording)
    }

    fn take(&mut self, found: Found) -> Result<(), RecordError> {
        match found {
            Found::Message(header, data, Some(topic)) => {
                self.message(&topic, header.log_time, &data)?;
            }
            Found::Attachment(header, data) => {
                self.attachments.insert(header.name, data);
            }
            Found::Metadata(metadata) if metadata.name == "run" => {
                self.meta = metadata.metadata;
                self.rows = GrainRows::of(&self.meta);
            }
            Found::Metadata(metadata) if metadata.name == "end" => self.end = metadata.metadata,
            Found::Metadata(metadata) if metadata.name == SPECIMEN => {
                return Err(RecordError::Specimen { path: self.path.clone() });
            }
            Found::Message(..)
            | Found::Metadata(_)
            | Found::Schema(..)
            | Found::Channel(_)
            | Found::ChunkEnd
            | Found::Hole
            | Found::Gone(_) => {}
        }
        Ok(())
    }

    /// How many bodies move or are made though nothing tells of their birth.
    fn count_unborn(&self) -> u64 {
        let born: HashSet<u64> = self.bodies.iter().map(|body| body.id).collect();
        let made = self.events.iter().flat_map(|event| &event.fragments);
        let moved = self.poses.iter().flat_map(|poses| &poses.ids);
        let unborn: HashSet<u64> =
            made.chain(moved).copied().filter(|body| !born.contains(body)).collect();
        unborn.len() as u64
    }

    fn message(&mut self, topic: &str, time: u64, data: &[u8]) -> Result<(), RecordError> {
        if topic == DEBRIS {
            return self.grains(time, data);
        }
        self.tally.message(topic, time, data)?;
        match topic {
            GEOMETRY => {
                let geometry: Geometry = decode(topic, time, data)?;
                self.geometries.insert(geometry.hash.clone(), geometry);
            }
            BODY => self.bodies.push(decode(topic, time, data)?),
            SHAPE => self.shapes.push(decode(topic, time, data)?),
            BODIES => self.poses.push(decode(topic, time, data)?),
            CRACKS => self.cracks.push(decode(topic, time, data)?),
            JOINTS => self.joints.push(decode(topic, time, data)?),
            EVENTS => self.events.push(decode(topic, time, data)?),
            JOBS => self.reports.push(decode(topic, time, data)?),
            POOL => self.pool.push(decode(topic, time, data)?),
            SAMPLED => self.sampled.push(decode(topic, time, data)?),
            APPEARANCE => self.appearances.push(decode(topic, time, data)?),
            SHEET_SURFACE => {
                let surface: SheetSurface = decode(topic, time, data)?;
                self.surfaces.insert(surface.hash.clone(), surface);
            }
            SHEETS => self.sheet_frames.push(decode(topic, time, data)?),
            WINDOWS => self.windows.push(decode(topic, time, data)?),
            _ => {}
        }
        Ok(())
    }

    /// Grains, with rows to the last bit whatever the form of the message.
    fn grains(&mut self, time: u64, data: &[u8]) -> Result<(), RecordError> {
        let told: Grains = decode(DEBRIS, time, data)?;
        let Some(LongForm { all, moved }) = self.rows.long(&told) else {
            self.tally.message(DEBRIS, time, data)?;
            self.rows.take(&told);
            self.debris.push(told);
            return Ok(());
        };
        self.tally.message(DEBRIS, time, &all.to_bytes())?;
        self.rows.take(&moved);
        if !moved.ids.is_empty() {
            self.debris.push(moved);
        }
        Ok(())
    }

    /// Digest of the geometry that a body has after so many steps; `None` of one that was never
    /// recorded.
    #[must_use]
    pub fn geometry_of(&self, body: u64, step: u64) -> Option<&[u8]> {
        let later = self.shapes.iter().rev().find(|it| it.body == body && it.step <= step);
        let born = || self.bodies.iter().find(|it| it.id == body).map(|it| &it.geometry[..]);
        later.map(|shape| &shape.geometry[..]).or_else(born)
    }

    /// Spacing of the last solve of each body that made anything of it \[m\].
    pub fn spacings(&self) -> BTreeMap<u64, f64> {
        let made = self.reports.iter().filter(|report| report.fragments > 0);
        made.map(|report| (report.body, report.spacing)).collect()
    }

    /// Where each fragment comes from; those of an old recording, which does not tell, are not in
    /// it.
    #[must_use]
    pub fn origins(&self) -> BTreeMap<u64, FragmentOrigin> {
        let told: BTreeMap<u64, &Sampled> = self.sampled.iter().map(|of| (of.body, of)).collect();
        let origin = |body: &Body| {
            let of = told.get(&body.parent?)?;
            let origin = match body.id {
                id if of.directed.contains(&id) => FragmentOrigin::Directed,
                id => FragmentOrigin::of_sampled(of.fragments.contains(&id)),
            };
            Some((body.id, origin))
        };
        self.bodies.iter().filter_map(origin).collect()
    }

    /// What objects look like inside, by name, where the scene says so.
    #[must_use]
    pub fn interiors(&self) -> BTreeMap<String, InteriorLook> {
        interiors(&self.meta)
    }

    /// Fragments that were drawn from a law, and not solved; none of an old recording.
    #[must_use]
    pub fn sampled_fragments(&self) -> BTreeSet<u64> {
        self.sampled.iter().flat_map(|sampled| &sampled.fragments).copied().collect()
    }

    /// What the windows of each sheet came to, by number.
    #[must_use]
    pub fn sheet_census(&self) -> &SheetCensus {
        self.tally.sheets()
    }

    /// The summary, made from the messages.
    #[must_use]
    pub fn summary(&self) -> Summary {
        let missing = (!self.holes.is_empty()).then(|| self.holes.to_string());
        Summary { missing, ..self.tally.summary(&self.meta, &self.end) }
    }
}
