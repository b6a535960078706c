#!/bin/bash
# Outputs on mounts, on overlays, in the working folder, and after a run of root: what no test can set up without root.
#
#   sudo tests/faults/mounts.sh [PROGRAM]      default: target/release/diffraction
#
# Prints what was there before and after each case. Exit code: 0 all right, 1 something is wrong, 2 it cannot run here.
# Everything happens in a temporary folder and in a mount namespace of its own; the machine's mounts stay as they are.
set -u

if [ "$(id -u)" != 0 ]; then
    echo "mounts.sh: needs root, to mount and to act for another user; run it with sudo" >&2
    exit 2
fi
if [ "${IN_NAMESPACE:-}" != 1 ]; then
    program=$(realpath "${1:-target/release/diffraction}") || exit 2
    IN_NAMESPACE=1 exec unshare --mount --propagation private "$0" "$program"
fi

program=$1
place=$(mktemp -d)
chmod 755 "$place"
trap 'cd /; umount -R "$place" 2>/dev/null; rm -rf "$place"' EXIT
mount -t tmpfs -o size=256m tmpfs "$place" || { echo "mounts.sh: tmpfs cannot be mounted here" >&2; exit 2; }
chmod 755 "$place"
cd "$place" || exit 2
# a user of no rights: 65534 is nobody on every Linux
user=65534
mkdir cache && chmod 1777 cache
export XDG_CACHE_HOME=$place/cache

write_plan() { # FILE HEIGHT TERMS
    cat > "$1" <<PLAN
schema = 1
[[surface]]
name = "a"
grating = { kind = "blazed", period_um = 2.5, height_um = $2, pixels = 100 }
[variants]
terms = [$3]
[targets]
emit = ["wgsl"]
PLAN
}
write_plan one.toml 0.3 12
write_plan two.toml 0.25 "12, 21"

wrong=0
case_name=
begin() { case_name=$1; echo "== $1"; }
right() { # DESCRIPTION COMMAND…
    local what=$1
    shift
    if "$@"; then echo "   right: $what"; else echo "   WRONG: $what"; wrong=$((wrong + 1)); fi
}
not() { ! "$@"; }
shown() { find "$1" -printf '%P %M %U:%G\n' 2>/dev/null | grep -v '^ ' | sort | head -${2:-12} | sed 's/^/      /'; }
generate() { "$program" generate --no-cache "$@" 2> said; }
is_clean() { "$program" generate --no-cache --check "$@" > checked 2> said; } # also: nothing but foreign files
as_user() { setpriv --reuid=$user --regid=$user --clear-groups env XDG_CACHE_HOME="$XDG_CACHE_HOME" "$@"; }
says() { grep -q "$1" said; }
no_litter() { [ -z "$(find "$1" -maxdepth 1 \( -name '*.tmp-*' -o -name '*.old-*' -o -name '.diffraction*' -o -name '.*.lock' \))" ]; }
inode() { stat -c %i "$1"; }

begin "a folder mounted inside of the output keeps everything"
generate --plan one.toml --out out
mkdir out/scans && mount -t tmpfs tmpfs out/scans && echo mine > out/scans/precious
echo "   before:"; shown out/scans
right "exit code 0" generate --plan two.toml --out out
echo "   after:"; shown out/scans
right "the mounted file is there" [ "$(cat out/scans/precious 2>/dev/null)" = mine ]
right "it is still mounted there" mountpoint -q out/scans
right "the package is the new one" is_clean --plan two.toml --out out
right "nothing is left beside it" no_litter . && no_litter out
umount out/scans; rm -rf out

begin "a part of the same disk mounted inside of the output keeps everything"
generate --plan one.toml --out out
mkdir out/scans store && echo mine > store/precious && mount --bind store out/scans
right "exit code 0" generate --plan two.toml --out out
right "the mounted file is there" [ "$(cat store/precious 2>/dev/null)" = mine ]
right "it is still mounted there" mountpoint -q out/scans
right "the package is the new one" is_clean --plan two.toml --out out
umount out/scans; rm -rf out store

begin "a mount over a folder of the package is refused before anything is done"
generate --plan one.toml --out out
mkdir store && echo mine > store/precious && mount --bind store out/shaders
cp out/manifest.json manifest.before
right "exit code 2" not generate --plan two.toml --out out
sed 's/^/      /' said
right "the message says what is mounted" says 'mount .*in the way'
right "the mounted file is there" [ "$(ls store)" = precious ]
umount out/shaders
right "the previous package is whole" is_clean --plan one.toml --out out
rm -rf out store

begin "an output that is a mount"
mkdir out && mount -t tmpfs tmpfs out
right "a first package: exit code 0" generate --plan one.toml --out out
echo mine > out/notes
right "another one: exit code 0" generate --plan two.toml --out out
sed 's/^/      /' said
right "the package is the new one" is_clean --plan two.toml --out out
right "foreign files stay" [ "$(cat out/notes)" = mine ]
right "nothing is left in it" no_litter out
mount -o remount,ro out
right "mounted read-only: exit code 2" not generate --plan one.toml --out out
sed 's/^/      /' said
right "mounted read-only: the package can be checked" is_clean --plan two.toml --out out
umount out; rmdir out

begin "an output that is a mount of the same disk, in a folder that cannot be written to"
mkdir -p store closed/out && chown $user store && mount --bind store closed/out
right "exit code 0 for another user" as_user "$program" generate --no-cache --plan one.toml --out closed/out
right "and again" as_user "$program" generate --no-cache --plan two.toml --out closed/out
right "the package is the new one" is_clean --plan two.toml --out closed/out
umount closed/out; rm -rf store closed

begin "an output on the lower layer of an overlay"
mkdir -p lower upper work merged
generate --plan one.toml --out lower/out
echo mine > lower/out/notes
if mount -t overlay overlay -o lowerdir=lower,upperdir=upper,workdir=work,redirect_dir=off merged; then
    right "exit code 0" generate --plan two.toml --out merged/out
    sed 's/^/      /' said
    right "the package is the new one" is_clean --plan two.toml --out merged/out
    right "foreign files stay" [ "$(cat merged/out/notes)" = mine ]
    right "nothing is left beside it or in it" no_litter merged && no_litter merged/out
    right "and once more" generate --plan one.toml --out merged/out
    right "the package is the new one" is_clean --plan one.toml --out merged/out
    umount merged
else
    echo "   WRONG: an overlay cannot be mounted here"; wrong=$((wrong + 1))
fi
rm -rf lower upper work merged

begin "the working folder as output"
mkdir out
number=$(inode out)
(cd out && "$program" generate --no-cache --plan ../one.toml --out . 2> ../said &&
    "$program" generate --no-cache --plan ../two.toml --out . 2> ../said && ls > ../listed)
right "exit code 0, and the shell still sees the folder" grep -q manifest.json listed
right "it is the same folder" [ "$(inode out)" = "$number" ]
right "the package is the new one" is_clean --plan two.toml --out out
(cd out/shaders && "$program" generate --no-cache --plan ../../one.toml --out .. 2> ../../said && ls > ../../listed)
right "from a folder below, too" grep -q a listed
rm -rf out

begin "after a run of root, the user's own"
mkdir home && chown $user home
as_user "$program" generate --no-cache --plan one.toml --out home/out
# as a run of root leaves it that is killed while it writes
"$program" generate --no-cache --plan two.toml --out home/copy 2> said
mkdir home/out.tmp-77 && cp -r home/copy home/out.tmp-77/new && rm -rf home/copy
[ -e mark.json ] || echo '{"left_by":"diffraction-shaders builds a package here; if no run does, the next one removes the folder","inode":0,"new":[],"old":[],"carried":[],"moving":false}' > mark.json
cp mark.json home/out.tmp-77/diffraction.json
echo "   before:"; shown home 8
right "exit code 0" as_user "$program" generate --no-cache --plan two.toml --out home/out 2> said
sed 's/^/      /' said
right "the message says whose the leftover is" says 'belongs to user root'
right "the package is the new one" is_clean --plan two.toml --out home/out
rm -r home/out.tmp-77
"$program" generate --no-cache --plan one.toml --out home/out 2> said
echo "   an output of the user, written by root:"; shown home/out 4
right "root leaves all of it to its owner" [ -z "$(find home/out ! -uid $user)" ]
right "the user's next run has nothing to say" as_user "$program" generate --no-cache --plan two.toml --out home/out 2> said
right "and leaves nothing" no_litter home
rm -rf home
mkdir home && chown $user home
generate --plan one.toml --out home/out
right "an output of root: exit code 2" not as_user "$program" generate --no-cache --plan two.toml --out home/out 2> said
sed 's/^/      /' said
right "the message says whose it is" says 'belongs to user root'
right "the previous package is whole" is_clean --plan one.toml --out home/out
rm -rf home

begin "foreign files and folders keep mode, owner and times"
generate --plan one.toml --out out
mkdir -p out/mine/deep out/shaders/mine
echo text > out/mine/deep/file; echo text > out/shaders/mine/file; echo text > out/alone; mkfifo out/pipe; ln -s nowhere out/link
chmod 2750 out/mine; chmod 0700 out/mine/deep; chmod 4711 out/mine/deep/file; chmod 0604 out/alone
chown -R 12345:54321 out/mine out/alone; chmod 2750 out/mine; chmod 4711 out/mine/deep/file
touch -d 2001-02-03 out/mine/deep/file out/mine/deep out/mine out/alone out/shaders/mine out/shaders/mine/file
list() { find out/mine out/shaders/mine out/alone out/pipe out/link -printf '%p %M %U:%G %T+ %i\n' | sort; }
list > before
right "exit code 0" generate --plan two.toml --out out
list > after
sed 's/^/      /' after
right "all as before" cmp -s before after
right "the package is the new one" is_clean --plan two.toml --out out
rm -rf out

begin "a folder of caches that cannot be written to, or is full"
mkdir closed && mount -t tmpfs -o size=16k tmpfs closed
for how in full read-only; do
    [ $how = full ] && { head -c 100000 /dev/zero > closed/fill; } 2> /dev/null
    [ $how = read-only ] && mount -o remount,ro closed
    rm -rf out
    right "$how: exit code 0" env XDG_CACHE_HOME="$place/closed" "$program" generate --plan two.toml --out out 2> said
    sed 's/^/      /' said
    right "$how: a note says so" says 'cache'
    right "$how: the package is right" is_clean --plan two.toml --out out
    right "$how: --no-cache needs no cache" env XDG_CACHE_HOME="$place/closed" "$program" generate --no-cache --plan one.toml --out out 2> said
done
umount closed; rm -rf out closed

begin "a file that is mounted by itself"
echo mine > store.png; touch map.png; mount --bind store.png map.png
right "exit code 2" not "$program" render --plan one.toml --surface a --size 16 --out map.png 2> said
sed 's/^/      /' said
right "the message says what to do" says 'mount the folder that holds it'
right "the file is as before" [ "$(cat store.png)" = mine ]
umount map.png; rm store.png map.png

begin "a disk that is full"
mkdir disk && mount -t tmpfs -o size=300k tmpfs disk
right "a first package: exit code 0" generate --plan one.toml --out disk/out
head -c 300000 /dev/zero > disk/fill 2> /dev/null
right "no room: exit code 2" not generate --plan two.toml --out disk/out
sed 's/^/      /' said
right "the previous package is whole" is_clean --plan one.toml --out disk/out
right "nothing is left beside it" no_litter disk
rm disk/fill
umount disk; rmdir disk

if [ $wrong != 0 ]; then
    echo "$wrong wrong"
    exit 1
fi
echo "all right"
