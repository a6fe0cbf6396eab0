//! Reading recordings, whole or cut off: every intact chunk counts, nothing else does.

use super::grains::{GrainRows, LongForm};
use super::meta::{InteriorLook, interiors};
use super::points::SPECIMEN;
use super::sheet_census::SheetCensus;
use super::summary::decode;
use super::{
    APPEARANCE, BODIES, BODY, CRACKS, DEBRIS, EVENTS, GEOMETRY, JOBS, JOINTS, POOL, RecordError,
    SAMPLED, SHAPE, SHEET_SURFACE, SHEETS, Summary, Tally, WINDOWS,
};
use cullet_model::FragmentOrigin;
use cullet_proto::recording::{
    Appearance, Body, BodyJoint, BodyPoses, Cracks, Geometry, Grains, JobReport, NewShape,
    PoolReport, Recorded, RunEvent, Sampled, SheetFrame, SheetSurface, SheetWindow,
};
use mcap::records::{Channel, MessageHeader, Record, SchemaHeader};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Bytes that a chunk may claim to unpack to. Ours have 8 MiB plus one message; a damaged length
/// must not ask for all memory.
const MAX_CHUNK_BYTES: usize = 1 << 30;
/// Bytes of a record's own header: opcode and length.
const RECORD_HEADER: usize = 9;

/// One thing found in a file, in file order.
pub(super) enum Found {
    Schema(SchemaHeader, Vec<u8>),
    Channel(Channel),
    Message(MessageHeader, Vec<u8>),
    Attachment(mcap::records::AttachmentHeader, Vec<u8>),
    Metadata(mcap::records::Metadata),
    ChunkEnd,
}

/// What a walk over a file came across beside its content.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Walk {
    /// True if the file ends as a finished file does.
    pub(super) ended: bool,
    /// Whole, intact chunks.
    pub(super) chunks: u64,
    /// Chunks that are there but damaged.
    pub(super) damaged: u64,
    /// Bytes at the end that are part of no whole record.
    pub(super) lost_bytes: u64,
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
pub(super) fn walk(
    path: &Path,
    bytes: &[u8],
    found: &mut dyn FnMut(Found) -> Result<(), RecordError>,
) -> Result<Walk, RecordError> {
    let Some(mut rest) = bytes.strip_prefix(mcap::MAGIC) else {
        return Err(RecordError::NotMcap { path: path.to_owned() });
    };
    let mut walk = Walk::default();
    while let Some((opcode, body, next)) = next_record(rest) {
        let whole = &rest[..RECORD_HEADER + body.len()];
        rest = next;
        let record = mcap::parse_record(opcode, body);
        match record {
            Ok(Record::Chunk { .. }) => match unpack(whole) {
                Some(content) => {
                    walk.chunks += 1;
                    content.into_iter().try_for_each(&mut *found)?;
                    found(Found::ChunkEnd)?;
                }
                None => walk.damaged += 1,
            },
            Ok(Record::DataEnd(_)) => {
                walk.ended = bytes.len() > 2 * mcap::MAGIC.len() && bytes.ends_with(mcap::MAGIC);
                return Ok(walk);
            }
            Ok(record) => {
                if let Some(content) = content(record) {
                    found(content)?;
                }
            }
            Err(_) => walk.damaged += 1,
        }
    }
    walk.lost_bytes = rest.len() as u64;
    Ok(walk)
}

/// Opcode and body of the next whole record, and what follows it.
fn next_record(rest: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (head, tail) = rest.split_at_checked(RECORD_HEADER)?;
    let length = u64::from_le_bytes(head[1..].try_into().ok()?);
    let (body, next) = tail.split_at_checked(usize::try_from(length).ok()?)?;
    Some((head[0], body, next))
}

/// The content of a chunk if all of it is intact. `record` is the whole record, opcode included.
/// The check sum is verified before anything inside is believed: a damaged length would otherwise
/// ask for more memory than there is.
fn unpack(mut record: &[u8]) -> Option<Vec<Found>> {
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(MAX_CHUNK_BYTES);
    let mut reader = LinearReader::new_with_options(options);
    let mut unpacked = Vec::new();
    while let Some(event) = reader.next_event() {
        match event.ok()? {
            LinearReadEvent::ReadRequest(wanted) => {
                let (now, later) = record.split_at(wanted.min(record.len()));
                reader.insert(now.len()).copy_from_slice(now);
                reader.notify_read(now.len());
                record = later;
            }
            LinearReadEvent::Record { data, opcode } => {
                unpacked.extend(content(mcap::parse_record(opcode, data).ok()?));
            }
        }
    }
    Some(unpacked)
}

fn content(record: Record<'_>) -> Option<Found> {
    match record {
        Record::Schema { header, data } => Some(Found::Schema(header, data.into_owned())),
        Record::Channel(channel) => Some(Found::Channel(channel)),
        Record::Message { header, data } => Some(Found::Message(header, data.into_owned())),
        Record::Attachment { header, data, .. } => {
            Some(Found::Attachment(header, data.into_owned()))
        }
        Record::Metadata(metadata) => Some(Found::Metadata(metadata)),
        _ => None,
    }
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
    /// True if something in it is not as it was written, or its end is missing though it has the
    /// name of a whole file.
    pub damaged: bool,
    tally: Tally,
    rows: GrainRows,
}

impl Recording {
    /// Reads `path`, or `<path>.partial` where only that exists. A file that was cut off reads up
    /// to its last whole chunk.
    ///
    /// # Errors
    /// No such file, no MCAP file, one of another program, or an intact chunk whose messages are
    /// not ours.
    pub fn open(path: &Path) -> Result<Self, RecordError> {
        let (path, bytes) = load(path)?;
        let mut recording = Self { path: path.clone(), ..Self::default() };
        let mut topics: BTreeMap<u16, String> = BTreeMap::new();
        let walk = walk(&path, &bytes, &mut |found| recording.take(found, &mut topics));
        let walk = match walk {
            // A topic of that name, but of another program.
            Err(RecordError::Decode { .. }) if recording.is_foreign() => {
                return Err(RecordError::Foreign { path });
            }
            walk => walk?,
        };
        // Of one that was cut off at its very beginning nothing is known.
        let some = walk.ended || walk.chunks > 0 || walk.damaged > 0 || !topics.is_empty();
        if some && recording.is_foreign() {
            return Err(match walk.damaged {
                0 => RecordError::Foreign { path },
                damaged => RecordError::Lost { path, damaged },
            });
        }
        let growing = path.extension().is_some_and(|end| end == "partial");
        recording.damaged = walk.damaged > 0 || !walk.ended && !growing;
        recording.complete =
            walk.ended && walk.damaged == 0 && recording.end.contains_key("wall_seconds");
        recording.lost_bytes = walk.lost_bytes;
        Ok(recording)
    }

    fn take(
        &mut self,
        found: Found,
        topics: &mut BTreeMap<u16, String>,
    ) -> Result<(), RecordError> {
        match found {
            Found::Channel(channel) => {
                topics.insert(channel.id, channel.topic);
            }
            Found::Message(header, data) => {
                if let Some(topic) = topics.get(&header.channel_id) {
                    self.message(topic, header.log_time, &data)?;
                }
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
            Found::Metadata(_) | Found::Schema(..) | Found::ChunkEnd => {}
        }
        Ok(())
    }

    /// Whether nothing of a run was found.
    fn is_foreign(&self) -> bool {
        let nothing = self.bodies.is_empty() && self.poses.is_empty() && self.events.is_empty();
        nothing && !self.meta.contains_key("scene")
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
        self.tally.summary(&self.meta, &self.end)
    }
}
