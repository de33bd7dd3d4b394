#!/bin/sh
# openfoam_headers.sh DIR: puts the headers of the installed OpenFOAM into DIR. Debian's package has none, so they come
# from Debian's own source package of the same version; the user's apt configuration is read, never changed.
# A second call on a complete DIR does nothing.
set -eu
dir=$1
version=$(dpkg-query -W -f '${source:Version}' libopenfoam)
if [ -e "$dir/version" ]; then
  [ "$(cat "$dir/version")" = "$version" ] && exit 0
  echo "openfoam_headers: the headers in $dir are of version $(cat "$dir/version"), the library is $version: fetching anew" >&2
fi
rm -rf "$dir"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$work/lists/partial" "$work/source" "$dir"

# source entries for the mirrors that this machine's binary packages come from
keyring=/usr/share/keyrings/debian-archive-keyring.gpg
signed=
[ -e "$keyring" ] && signed="[signed-by=$keyring]"
apt-get indextargets --format '$(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' | sort -u |
  awk -v signed="$signed" '/debian/ { print "deb-src " signed " " $1 " " $2 " " $3 }' >"$work/sources.list"
cat >"$work/apt.conf" <<EOF
Dir::Etc::SourceList "$work/sources.list";
Dir::Etc::SourceParts "-";
Dir::State::Lists "$work/lists";
APT::Sandbox::User "root";
EOF
export APT_CONFIG="$work/apt.conf"
apt-get update -qq
(cd "$work/source" && apt-get source -qq --download-only "openfoam=$version")
tar xf "$work"/source/openfoam_*.orig.tar.* -C "$work/source" --strip-components=1 --wildcards '*/src' '*/wmake'

# one flat folder of links a library, as OpenFOAM's own build makes them
for library in OpenFOAM OSspecific/POSIX finiteVolume meshTools fileFormats surfMesh transportModels \
  thermophysicalModels/basic thermophysicalModels/specie TurbulenceModels/turbulenceModels TurbulenceModels/compressible; do
  (cd "$work/source/src/$library" && WM_DIR="$work/source/wmake" WM_PROJECT_DIR="$work/source" sh "$work/source/wmake/wmakeLnInclude" -silent . >/dev/null 2>&1)
  mkdir -p "$dir/$library"
  cp -L "$work/source/src/$library/lnInclude/"* "$dir/$library/"
done
echo "$version" >"$dir/version"
