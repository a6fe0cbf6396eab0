//! What is missing in a recording is said by whoever reads it, also once it was recovered.

use super::synthetic;
use super::*;
use std::collections::BTreeMap;
use std::path::Path;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// A recording, and where the chunk with the births of fragments lies in it.
fn recorded(dir: &Path) -> (Vec<u8>, std::ops::Range<usize>) {
    let path = synthetic::run(&dir.join("run.mcap"), &synthetic::meta()).expect("records").path;
    let bytes = std::fs::read(path).expect("reads");
    let index = mcap::Summary::read(&bytes).expect("reads").expect("is indexed");
    let born = |chunk: &&mcap::records::ChunkIndex| {
        let mut channels = chunk.message_index_offsets.keys();
        channels.any(|id| index.channels[id].topic == BODY)
    };
    let chunk = index.chunk_indexes.iter().rfind(born).expect("births");
    let start = chunk.chunk_start_offset as usize;
    (bytes, start..start + chunk.chunk_length as usize)
}

fn opened(path: &Path, bytes: &[u8]) -> Recording {
    std::fs::write(path, bytes).expect("writes");
    Recording::open(path).expect("opens")
}

#[test]
fn a_recovered_recording_remembers_its_holes() {
    let dir = folder();
    let (mut bytes, chunk) = recorded(dir.path());
    bytes[(chunk.start + chunk.end) / 2] ^= 1;
    let (from, to) = (dir.path().join("damaged.mcap"), dir.path().join("recovered.mcap"));
    let damaged = opened(&from, &bytes);
    let saved = recover(&from, &to).expect("recovers");
    assert_eq!((saved.complete, &saved.holes.parts), (false, &1));
    let again = dir.path().join("again.mcap");
    let twice = recover(&to, &again).expect("recovers");
    assert_eq!((twice.complete, twice.damaged), (false, 0));
    for path in [&from, &to, &again] {
        let recording = Recording::open(path).expect("opens");
        assert_eq!(recording.holes, damaged.holes);
        assert!(recording.damaged && !recording.complete);
        let Holes { parts, records, unborn, spans, .. } = &recording.holes;
        assert_eq!((*parts, *unborn, spans.len()), (1, 2, 1));
        assert!(records[BODIES] >= 1 && records[BODY] == 2, "{records:?}");
        let told = inspect(path).expect("reads");
        assert!(told.events[0].contains("has holes"), "{:?}", told.events);
        assert!(told.events.iter().all(|line| !line.contains("held")), "{:?}", told.events);
        let missing = told.summary.missing.expect("some is missing");
        for part in ["a part of the file is damaged", "2 of /body", "2 bodies", "from step "] {
            assert!(missing.contains(part), "{missing}");
        }
        assert!(matches!(RunTrail::read(path), Err(RecordError::Patchy { .. })));
    }
}

/// What was recovered before holes had marks: the chunk is gone without a trace.
#[test]
fn messages_that_do_not_follow_one_another_are_missed() {
    let dir = folder();
    let (mut bytes, chunk) = recorded(dir.path());
    let whole = Recording::open(&dir.path().join("run.mcap")).expect("opens");
    assert!(whole.holes.is_empty() && whole.summary().missing.is_none());
    assert!(!whole.summary().to_json().contains("missing"));
    bytes.drain(chunk);
    let cut = opened(&dir.path().join("cut.mcap"), &bytes);
    assert_eq!((cut.holes.parts, cut.holes.unborn), (0, 2));
    let there = (whole.poses.len() - cut.poses.len()) as u64;
    assert_eq!(cut.holes.records[BODIES], there);
    assert!(cut.damaged && !cut.complete && !cut.holes.spans.is_empty());
}

#[test]
fn a_recording_that_only_ends_early_has_no_holes() {
    let dir = folder();
    let (bytes, chunk) = recorded(dir.path());
    let cut = opened(&dir.path().join("cut.mcap"), &bytes[..chunk.end - 7]);
    assert!(cut.holes.is_empty() && cut.damaged && !cut.complete, "{}", cut.holes);
    let growing = opened(&dir.path().join("cut.mcap.partial"), &bytes[..chunk.end - 7]);
    assert!(growing.holes.is_empty() && !growing.damaged, "{}", growing.holes);
}

/// The number of the last chunk.
const LAST: usize = usize::MAX;

/// Where a chunk of a recording lies in it.
fn chunk(bytes: &[u8], which: usize) -> std::ops::Range<usize> {
    let index = mcap::Summary::read(bytes).expect("reads").expect("is indexed").chunk_indexes;
    let chunk = index.get(which).or(index.last()).expect("a chunk");
    let start = chunk.chunk_start_offset as usize;
    start..start + chunk.chunk_length as usize
}

/// What the end of a file says leads over a length or an opcode that is damaged.
#[test]
fn a_damaged_length_or_opcode_costs_one_part_and_the_rest_is_read() {
    let dir = folder();
    let (sound, _) = recorded(dir.path());
    let whole = Recording::open(&dir.path().join("run.mcap")).expect("opens");
    let (from, to) = (dir.path().join("damaged.mcap"), dir.path().join("recovered.mcap"));
    let count = mcap::Summary::read(&sound).expect("reads").expect("is indexed");
    let (count, attachment) = (count.chunk_indexes.len(), count.attachment_indexes[0].offset);
    let chunk = chunk(&sound, 1);
    // The highest and the lowest byte of the length, then the opcode.
    for (at, bit) in [(8, 0x40), (1, 1), (2, 4), (0, 0x80)] {
        for (start, chunks) in [(chunk.start, count - 1), (attachment as usize, count)] {
            let mut bytes = sound.clone();
            bytes[start + at] ^= bit;
            let damaged = opened(&from, &bytes);
            assert_eq!((damaged.holes.parts, damaged.lost_bytes), (1, 0), "{at}, {bit}");
            assert!(damaged.damaged && !damaged.complete);
            assert!(damaged.poses.last() == whole.poses.last(), "the rest is read");
            let saved = recover(&from, &to).expect("recovers");
            assert_eq!((saved.damaged, saved.chunks), (1, chunks as u64), "{at}, {bit}");
            let copy = Recording::open(&to).expect("opens");
            assert!(copy.damaged && copy.holes == damaged.holes, "{}", copy.holes);
            std::fs::remove_file(&to).expect("it is there");
        }
    }
}

#[test]
fn a_damaged_length_is_told_where_nothing_leads_over_it() {
    let dir = folder();
    let (mut bytes, _) = recorded(dir.path());
    let start = chunk(&bytes, 1).start;
    bytes[start + 8] ^= 0x40;
    // The check sum of the summary, before the last magic.
    let end = bytes.len() - mcap::MAGIC.len();
    bytes[end - 1] ^= 1;
    let (from, to) = (dir.path().join("damaged.mcap"), dir.path().join("recovered.mcap"));
    let damaged = opened(&from, &bytes);
    assert_eq!((damaged.holes.parts, damaged.lost_bytes), (1, (bytes.len() - start) as u64));
    assert!(damaged.damaged && damaged.summary().missing.is_some());
    recover(&from, &to).expect("recovers");
    let copy = Recording::open(&to).expect("opens");
    assert!(copy.damaged && copy.holes == damaged.holes, "{}", copy.holes);
}

#[test]
fn a_sound_recording_whose_index_is_damaged_has_no_holes() {
    let dir = folder();
    let (mut bytes, _) = recorded(dir.path());
    let summary = mcap::Summary::read(&bytes).expect("reads").expect("is indexed");
    let counted = summary.stats.expect("counts").message_count.to_le_bytes();
    let at = bytes.windows(8).rposition(|at| at == counted).expect("it is there");
    // The counts by channel are behind it, each after the number of its channel.
    let channels = summary.channels.len();
    (0..channels).for_each(|channel| bytes[at + 48 + 10 * channel + 5] ^= 1);
    let read = opened(&dir.path().join("damaged.mcap"), &bytes);
    assert!(read.holes.is_empty() && read.complete, "{}", read.holes);
}

/// No later message misses what was in it, and only the end of the file does.
#[test]
fn the_last_chunk_is_missed_and_topics_that_only_it_has() {
    let dir = folder();
    let (sound, _) = recorded(dir.path());
    let whole = Recording::open(&dir.path().join("run.mcap")).expect("opens");
    let mut cut = sound.clone();
    cut.drain(chunk(&sound, LAST));
    let cut = opened(&dir.path().join("cut.mcap"), &cut);
    assert!(cut.holes.records[EVENTS] > 0, "{}", cut.holes);
    assert!(cut.damaged && !cut.complete && cut.holes.parts == 0);
    assert!(matches!(cut.holes.spans[..], [[_, u64::MAX]]), "{}", cut.holes);
    let to = dir.path().join("recovered.mcap");
    recover(&dir.path().join("cut.mcap"), &to).expect("recovers");
    assert_eq!(Recording::open(&to).expect("opens").holes, cut.holes);
    // All chunks at once: no channel is declared any more.
    let mut none = sound.clone();
    none.drain(chunk(&sound, 0).start..chunk(&sound, LAST).end);
    let none = opened(&dir.path().join("none.mcap"), &none);
    assert_eq!(none.holes.records[BODIES], whole.poses.len() as u64);
}

/// An MCAP file of another program, with so many chunks that each unpack to so many bytes.
fn foreign(count: usize, size: usize) -> Vec<u8> {
    let options = mcap::WriteOptions::new().chunk_size(None).compression_threads(0);
    let mut writer = options.create(std::io::Cursor::new(Vec::new())).expect("begins");
    let schema = writer.add_schema("other.Body", "protobuf", &[]).expect("a schema");
    let channel = writer.add_channel(schema, BODY, "protobuf", &BTreeMap::new());
    let header = |sequence| mcap::records::MessageHeader {
        channel_id: *channel.as_ref().expect("a channel"),
        sequence,
        log_time: 0,
        publish_time: 0,
    };
    writer.write_to_known_channel(&header(0), &vec![0; size]).expect("writes");
    writer.finish().expect("ends");
    let one = writer.into_inner().into_inner();
    let index = mcap::Summary::read(&one).expect("reads").expect("is indexed").chunk_indexes;
    let start = index[0].chunk_start_offset as usize;
    let end = start + index[0].chunk_length as usize;
    [&one[..start], &one[start..end].repeat(count), &one[end..]].concat()
}

#[test]
fn the_file_of_another_program_is_not_recovered() {
    let dir = folder();
    let (from, to) = (dir.path().join("other.mcap"), dir.path().join("out.mcap"));
    std::fs::write(&from, foreign(3, 100)).expect("writes");
    for said in [recover(&from, &to).map(drop), Recording::open(&from).map(drop)] {
        assert!(matches!(said, Err(RecordError::Foreign { .. })), "{said:?}");
    }
    assert_eq!(std::fs::read_dir(dir.path()).expect("a folder").count(), 1);
}

/// Each chunk may unpack to so much, and all together may not.
#[test]
fn all_chunks_together_have_a_bound() {
    let dir = folder();
    let (from, to) = (dir.path().join("bomb.mcap"), dir.path().join("out.mcap"));
    std::fs::write(&from, foreign(17, 1 << 25)).expect("writes");
    assert!(std::fs::metadata(&from).expect("a file").len() < 1 << 17);
    let said = [recover(&from, &to).map(drop), Recording::open(&from).map(drop)];
    for said in said.into_iter().chain([RunTrail::read(&from).map(drop)]) {
        let Err(why @ RecordError::Swollen { bound, .. }) = said else { panic!("{said:?}") };
        let why = why.to_string();
        assert!(why.contains("bomb.mcap") && why.contains(&bound.to_string()), "{why}");
    }
    assert_eq!(std::fs::read_dir(dir.path()).expect("a folder").count(), 1);
    // Each is unpacked before its check sum is known to be wrong.
    let mut bytes = foreign(17, 1 << 25);
    let one = chunk(&foreign(1, 1 << 25), 0);
    for number in 0..17 {
        bytes[one.start + number * one.len() + 9 + 24] ^= 1;
    }
    std::fs::write(&from, bytes).expect("writes");
    let said = Recording::open(&from).map(drop);
    assert!(matches!(said, Err(RecordError::Swollen { .. })), "{said:?}");
}

#[test]
fn what_a_killed_recovery_left_is_removed_and_one_at_work_is_not() {
    let dir = folder();
    let (bytes, _) = recorded(dir.path());
    let at = |name: &str| dir.path().join(name);
    for left in ["a.mcap.recovering", "out.mcap.recovering", "busy.mcap.recovering"] {
        std::fs::write(at(left), &bytes[..100]).expect("writes");
    }
    let busy = std::fs::File::open(at("busy.mcap.recovering")).expect("opens");
    busy.lock().expect("a lock");
    recover(&at("run.mcap"), &at("out.mcap")).expect("recovers");
    assert!(!at("a.mcap.recovering").exists() && !at("out.mcap.recovering").exists());
    let why = recover(&at("run.mcap"), &at("busy.mcap")).expect_err("it is at work").to_string();
    assert!(why.contains("another recovery") && at("busy.mcap.recovering").exists(), "{why}");
}
