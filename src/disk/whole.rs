//! Files that are read without waiting and written whole or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

use super::{is_mount, owner};

/// Begins the names of files that are being written. A run that is killed at such a moment may leave one.
const PARTIAL: &str = ".diffraction-tmp-";

/// Opens a regular file to read. Anything else is an error, at once: a pipe without a writer would never open.
pub fn open_regular(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        options.custom_flags(rustix::fs::OFlags::NONBLOCK.bits() as i32);
    }
    let file = options.open(path)?;
    match file.metadata()?.is_file() {
        true => Ok(file),
        false => Err(io::Error::other("is not a regular file")),
    }
}

/// Reads a regular file.
pub fn read_regular(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = open_regular(path)?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Removes what stands where one of our files must go: a link, a pipe, an empty folder, a read-only file. If
/// that fails, the file cannot be written.
pub fn clear(path: &Path) {
    let Ok(found) = fs::symlink_metadata(path) else { return };
    if found.is_dir() {
        let _ = fs::remove_dir(path);
    } else if !found.is_file() || found.permissions().readonly() {
        let _ = fs::remove_file(path);
    }
}

/// Writes a file completely or not at all: it is written under no name or another one, and takes its name at the end.
///
/// A link is followed and stays. A pipe that is being read, a terminal and `/dev/null` are written to as they are. It is an
/// error to name a folder, a file that is read-only, a link that leads nowhere, or, in a folder that everybody may write to,
/// somebody else's link.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let failed = |e: io::Error| {
        let error = Error::new(path.display(), "cannot be written").source(e);
        error.remedy("check permissions and free space of the folder that holds it")
    };
    if let Some(mut stream) = standard(path) {
        return stream.write_all(bytes).and_then(|()| stream.flush()).map_err(failed);
    }
    match target(path)? {
        Target::Stream(mut file) => file.write_all(bytes).map_err(failed),
        Target::File(path, before) => replace(&path, before, bytes).map_err(failed),
    }
}

/// What a path stands for.
enum Target {
    /// A file: its path without links, and what is there before.
    File(PathBuf, Option<fs::Metadata>),
    /// What has no content of its own: a pipe, a terminal, `/dev/null`.
    Stream(File),
}

/// The stream of this process that a path stands for. Opened anew, a file would be written from its beginning.
fn standard(path: &Path) -> Option<Box<dyn Write>> {
    match path.to_str()? {
        "/dev/stdout" | "/dev/fd/1" | "/proc/self/fd/1" => Some(Box::new(io::stdout())),
        "/dev/stderr" | "/dev/fd/2" | "/proc/self/fd/2" => Some(Box::new(io::stderr())),
        _ => None,
    }
}

fn target(path: &Path) -> Result<Target> {
    let error = |cause: &str| Error::new(path.display(), cause);
    let other = "name another file";
    let is_link = fs::symlink_metadata(path).is_ok_and(|found| found.is_symlink());
    if is_link && !is_trusted(path) {
        let cause = match owner(path) {
            Some(owner) => {
                format!("is a link of user {owner} in a folder that everybody may write to")
            }
            None => "is somebody else's link in a folder that everybody may write to".to_owned(),
        };
        return Err(error(&cause).remedy(other));
    }
    let found = match fs::metadata(path) {
        Ok(found) => found,
        Err(e) if e.kind() == io::ErrorKind::NotFound && is_link => {
            return Err(error("is a link to a file that does not exist")
                .remedy("remove the link, or name another file"));
        }
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            let name = path.file_name().ok_or_else(|| error("is not the path of a file"))?;
            return Ok(Target::File(folder_of(path).join(name), None));
        }
        Err(e) => return Err(error("cannot be written").source(e).remedy(other)),
    };
    if found.is_dir() {
        return Err(error("is a folder").remedy("name a file"));
    }
    if found.is_file() && !path.starts_with("/dev/fd") && !path.starts_with("/proc") {
        let read_only = |e: io::Error| {
            let whose = owner(path).map(|owner| format!("; it belongs to user {owner}"));
            let remedy =
                format!("name another file, or make it writable{}", whose.unwrap_or_default());
            error("may not be written").source(e).remedy(remedy)
        };
        if found.permissions().readonly() {
            return Err(error("is read-only").remedy("name another file, or make it writable"));
        }
        OpenOptions::new().write(true).open(path).map_err(read_only)?;
        let whole = fs::canonicalize(path).map_err(read_only)?;
        if is_mount(&whole).unwrap_or(false) {
            return Err(error("is mounted by itself, so that no other file can take its place")
                .remedy("mount the folder that holds it, or name another file"));
        }
        return Ok(Target::File(whole, Some(found)));
    }
    stream(path, &found).map(Target::Stream)
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|parent| *parent != Path::new("")).unwrap_or(Path::new("."))
}

/// Opens what has no content of its own, without waiting for anybody.
#[cfg(unix)]
fn stream(path: &Path, found: &fs::Metadata) -> Result<File> {
    use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
    use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
    let error = |cause: &str| Error::new(path.display(), cause).remedy("name a file");
    let kind = found.file_type();
    if kind.is_socket() || kind.is_block_device() {
        return Err(error("is a socket or a disk"));
    }
    let flags = OFlags::NONBLOCK | OFlags::NOCTTY;
    let opened = OpenOptions::new().append(true).custom_flags(flags.bits() as i32).open(path);
    let file = opened.map_err(|e| {
        let no_reader = e.raw_os_error() == Some(rustix::io::Errno::NXIO.raw_os_error());
        let cause = if no_reader { "is a pipe that nobody reads" } else { "cannot be opened" };
        error(cause).source(e).remedy("start its reader first, or name a file")
    })?;
    fcntl_getfl(&file)
        .and_then(|flags| fcntl_setfl(&file, flags - OFlags::NONBLOCK))
        .map_err(|e| error("cannot be written").source(io::Error::from(e)))?;
    Ok(file)
}

#[cfg(not(unix))]
fn stream(path: &Path, _found: &fs::Metadata) -> Result<File> {
    Err(Error::new(path.display(), "is not a regular file").remedy("name a file"))
}

/// Whether a link may be followed: by the rule of Linux for folders that everybody may write to, where anybody may have
/// put it there.
#[cfg(unix)]
fn is_trusted(path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    const STICKY_AND_OPEN: u32 = 0o1002;
    let (Ok(link), Ok(folder)) = (fs::symlink_metadata(path), fs::metadata(folder_of(path))) else {
        return false;
    };
    let is_open = folder.mode() & STICKY_AND_OPEN == STICKY_AND_OPEN;
    !is_open || link.uid() == folder.uid() || link.uid() == rustix::process::geteuid().as_raw()
}

#[cfg(not(unix))]
fn is_trusted(_path: &Path) -> bool {
    true
}

/// Puts a new file in the place of one that may be there, with its permissions.
fn replace(path: &Path, before: Option<fs::Metadata>, bytes: &[u8]) -> io::Result<()> {
    let like_before = |file: &File| match &before {
        Some(before) => {
            // the owner first, since a change of owner takes special bits away
            owned_like(file, before);
            file.set_permissions(before.permissions())
        }
        None => Ok(()),
    };
    #[cfg(target_os = "linux")]
    if let Some(mut file) = nameless(folder_of(path)) {
        file.write_all(bytes)?;
        like_before(&file)?;
        if let Some(done) = named(&file, path, before.is_none()) {
            return done;
        }
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(PARTIAL);
    #[cfg(unix)]
    {
        // as any new file; otherwise it would be readable to its owner alone
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder_of(path))?;
    file.write_all(bytes)?;
    like_before(file.as_file())?;
    file.persist(path).map(|_| ()).map_err(|e| e.error)
}

#[cfg(unix)]
fn owned_like(file: &File, before: &fs::Metadata) {
    use std::os::unix::fs::{MetadataExt, fchown};
    if file.metadata().is_ok_and(|now| (now.uid(), now.gid()) != (before.uid(), before.gid())) {
        // only root may give files away
        let _ = fchown(file, Some(before.uid()), Some(before.gid()));
    }
}

#[cfg(not(unix))]
fn owned_like(_file: &File, _before: &fs::Metadata) {}

/// A file without a name, of which nothing is left if the run is killed. `None` where the file system has no such files.
#[cfg(target_os = "linux")]
fn nameless(folder: &Path) -> Option<File> {
    use rustix::fs::{CWD, Mode, OFlags, openat};
    let flags = OFlags::TMPFILE | OFlags::WRONLY | OFlags::CLOEXEC;
    openat(CWD, folder, flags, Mode::from_raw_mode(0o666)).ok().map(File::from)
}

/// Names a file. `None`: it cannot be named, and has to be written in another way.
#[cfg(target_os = "linux")]
fn named(file: &File, path: &Path, is_new: bool) -> Option<io::Result<()>> {
    use rustix::fs::{AtFlags, CWD, linkat};
    use rustix::io::Errno;
    use std::os::fd::AsRawFd;
    let own = format!("/proc/self/fd/{}", file.as_raw_fd());
    let link = |to: &Path| linkat(CWD, &own, CWD, to, AtFlags::SYMLINK_FOLLOW);
    if is_new {
        match link(path) {
            Ok(()) => return Some(Ok(())),
            // somebody made one meanwhile
            Err(Errno::EXIST) => {}
            Err(_) => return None,
        }
    }
    for count in 0..100 {
        let partial = folder_of(path).join(format!("{PARTIAL}{}-{count}", std::process::id()));
        match link(&partial) {
            Ok(()) => {
                let done = fs::rename(&partial, path);
                if done.is_err() {
                    let _ = fs::remove_file(&partial);
                }
                return Some(done);
            }
            Err(Errno::EXIST) => {}
            Err(_) => return None,
        }
    }
    None
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::{PermissionsExt, symlink};

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder").flatten();
        let mut names: Vec<_> =
            entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    fn refusal(path: &Path) -> String {
        write_whole(path, b"new").expect_err("is refused").to_string()
    }

    #[test]
    fn a_file_is_written_and_replaced_and_nothing_else_is_there() {
        let place = tempfile::tempdir().expect("a folder");
        let file = place.path().join("file");
        write_whole(&file, b"one").expect("writes");
        let fresh = fs::metadata(&file).expect("there").permissions().mode() & 0o777;
        fs::write(place.path().join("plain"), "").expect("writes");
        let plain = fs::metadata(place.path().join("plain")).expect("there").permissions().mode();
        assert_eq!(fresh, plain & 0o777, "as any new file");
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).expect("sets");
        write_whole(&file, b"two").expect("writes");
        assert_eq!(fs::read(&file).expect("reads"), b"two");
        assert_eq!(fs::metadata(&file).expect("there").permissions().mode() & 0o777, 0o640);
        assert_eq!(names(place.path()), ["file", "plain"]);
        let absent = place.path().join("absent/file");
        assert!(refusal(&absent).contains("cannot be written"));
    }

    /// Both ways of writing, since a file system has one of them.
    #[test]
    fn a_file_can_be_named_without_an_own_folder_of_names() {
        let place = tempfile::tempdir().expect("a folder");
        let file = place.path().join("file");
        for (round, text) in ["one", "two"].into_iter().enumerate() {
            #[cfg(target_os = "linux")]
            if let Some(mut new) = nameless(place.path()) {
                new.write_all(text.as_bytes()).expect("writes");
                named(&new, &file, round == 0).expect("is named").expect("is named");
                assert_eq!(fs::read_to_string(&file).expect("reads"), text);
            }
            replace(&file, None, text.as_bytes()).expect("writes");
            assert_eq!((round, fs::read_to_string(&file).expect("reads")), (round, text.into()));
        }
        assert_eq!(names(place.path()), ["file"]);
    }

    #[test]
    fn a_link_stays_and_one_that_leads_nowhere_is_refused() {
        let place = tempfile::tempdir().expect("a folder");
        let at = |name: &str| place.path().join(name);
        fs::write(at("real"), "old").expect("writes");
        symlink("real", at("link")).expect("links");
        write_whole(&at("link"), b"new").expect("writes");
        assert!(fs::symlink_metadata(at("link")).expect("there").is_symlink());
        assert_eq!(fs::read(at("real")).expect("reads"), b"new");
        symlink("absent", at("nowhere")).expect("links");
        assert!(refusal(&at("nowhere")).contains("does not exist"));
        assert_eq!(names(place.path()), ["link", "nowhere", "real"]);
    }

    #[test]
    fn what_is_no_file_is_refused_or_written_to() {
        let place = tempfile::tempdir().expect("a folder");
        assert!(refusal(place.path()).contains("is a folder (name a file)"));
        write_whole(Path::new("/dev/null"), b"gone").expect("writes");
        assert!(fs::metadata("/dev/null").is_ok_and(|found| !found.is_file()), "it is still there");
        let file = place.path().join("file");
        fs::write(&file, "mine").expect("writes");
        fs::set_permissions(&file, fs::Permissions::from_mode(0o444)).expect("sets");
        assert!(refusal(&file).contains("is read-only"));
        assert_eq!(fs::read(&file).expect("reads"), b"mine");
    }

    #[test]
    fn a_pipe_gets_the_bytes_if_somebody_reads_them() {
        let place = tempfile::tempdir().expect("a folder");
        let pipe = place.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().expect("mkfifo runs");
        assert!(made.success());
        assert!(refusal(&pipe).contains("nobody reads"));
        assert!(open_regular(&pipe).is_err(), "and nobody waits for a writer");
        let copy = File::create(place.path().join("copy")).expect("creates");
        let mut reader =
            std::process::Command::new("cat").arg(&pipe).stdout(copy).spawn().expect("cat runs");
        let bytes = vec![7; 300_000];
        let mut written = write_whole(&pipe, &bytes);
        for _ in 0..500 {
            // the reader may not have begun yet
            if written.is_ok() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(10));
            written = write_whole(&pipe, &bytes);
        }
        written.expect("writes");
        assert!(reader.wait().expect("ends").success());
        assert_eq!(fs::read(place.path().join("copy")).expect("reads"), bytes);
    }
}
