#!/usr/bin/env bash
# Keys, certificates and permissions for DDS-Security (docs/dds.md): dds_keys.sh FOLDER NAME[=ROLE]...
#
# Makes FOLDER/NAME for each participant, with the six files that `dds: {security: {folder: ...}}` and
# `stillpoint watch --security` take. ROLE says what it may do:
#   reader   reads every topic, publishes nothing (the default)
#   daemon   publishes what stillpointd publishes, reads the raw input of a driver
#   driver   publishes imu/data_raw and imu/mag, reads nothing
# Whoever has FOLDER/ca/key.pem can make participants: keep it away from the machines that the others go to.
#
# What is there is kept. To change what a participant may do, or how the domain is protected, edit NAME/permissions.xml
# or ca/governance.xml and run this again: both are signed anew. To renew a certificate, remove NAME/cert.pem first.
# DAYS=N sets how long what is made is valid (3650).
set -euo pipefail
umask 077
usage() { sed -n 's/^# \{0,1\}//; 2,13p' "$0" >&2; exit 64; }
[ $# -ge 2 ] || usage
case $1 in -*) usage ;; esac
command -v openssl > /dev/null || { echo "dds_keys.sh: openssl is missing; apt install openssl" >&2; exit 69; }
folder=$1; shift
days=${DAYS:-3650}

for participant in "$@"; do
  case ${participant%%=*} in
    ca | . | .. | "" | *[!A-Za-z0-9_.-]*)
      echo "dds_keys.sh: '${participant%%=*}' is no name: letters, digits, _ . and -, and not ca" >&2; exit 64 ;;
  esac
  case $participant in
    *=reader | *=daemon | *=driver) ;;
    *=*) echo "dds_keys.sh: role '${participant#*=}' is not known; use reader, daemon or driver" >&2; exit 64 ;;
  esac
done

new_key() { openssl ecparam -name prime256v1 -genkey -noout -out "$1"; }
sign() { openssl smime -sign -text -in "$1" -out "$2" -signer "$folder/ca/cert.pem" -inkey "$folder/ca/key.pem"; }

mkdir -p "$folder/ca"
if [ ! -e "$folder/ca/key.pem" ]; then
  new_key "$folder/ca/key.pem"
  openssl req -x509 -new -sha256 -days "$days" -subj "/CN=stillpoint-ca" -key "$folder/ca/key.pem" -out "$folder/ca/cert.pem"
fi
# Every topic: nobody without keys is let in, and all that endpoints send is encrypted with keys of their own, so that
# only who may read a topic can. A layer around whole messages (rtps_protection_kind) would add cost and hide no more.
[ -e "$folder/ca/governance.xml" ] || cat > "$folder/ca/governance.xml" << 'XML'
<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      <domains><id_range><min>0</min><max>232</max></id_range></domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>NONE</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
          <data_protection_kind>NONE</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
XML

topics() { # publish|subscribe TOPIC...
  echo "        <$1><topics>"
  for topic in "${@:2}"; do echo "          <topic>$topic</topic>"; done
  echo "        </topics></$1>"
}
rules_of() {
  case $1 in
    daemon)
      topics publish '*stillpoint/*' 'rt/*imu/*' rt/diagnostics
      topics subscribe 'rt/*' ;;
    driver) topics publish 'rt/*imu/data_raw' 'rt/*imu/mag' ;;
    reader) topics subscribe '*' ;;
  esac
}
permissions_of() { # NAME ROLE
  cat << XML
<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions>
    <grant name="$1">
      <subject_name>CN=$1</subject_name>
      <validity>
        <not_before>2000-01-01T00:00:00</not_before>
        <not_after>$(date -u -d "+$days days" +%Y-%m-%dT%H:%M:%S)</not_after>
      </validity>
      <allow_rule>
        <domains><id_range><min>0</min><max>232</max></id_range></domains>
$(rules_of "$2")
      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
XML
}

for participant in "$@"; do
  name=${participant%%=*}
  role=${participant#"$name"}; role=${role#=}
  own=$folder/$name
  mkdir -p "$own"
  [ -e "$own/key.pem" ] || new_key "$own/key.pem"
  if [ ! -e "$own/cert.pem" ]; then
    openssl req -new -sha256 -subj "/CN=$name" -key "$own/key.pem" |
      openssl x509 -req -sha256 -days "$days" -CA "$folder/ca/cert.pem" -CAkey "$folder/ca/key.pem" \
        -CAcreateserial -out "$own/cert.pem" 2> /dev/null
  fi
  [ -e "$own/permissions.xml" ] || permissions_of "$name" "${role:-reader}" > "$own/permissions.xml"
  cp "$folder/ca/cert.pem" "$own/identity_ca.cert.pem"
  cp "$folder/ca/cert.pem" "$own/permissions_ca.cert.pem"
  sign "$folder/ca/governance.xml" "$own/governance.p7s"
  sign "$own/permissions.xml" "$own/permissions.p7s"
  echo "$own"
done
