# Egosieve in a container: `docker build -t egosieve .`, then
#
#   docker run --rm -v "$PWD":/data egosieve segment /data/my.mp4 --out=/data/out/my
#
# The first stage builds with ./run, as on any Debian; the second has what the program needs to run,
# and no compiler but PoCL's. --build-arg DEBIAN=bookworm for Debian 12.
ARG DEBIAN=trixie

FROM debian:${DEBIAN}-slim AS build
COPY . /egosieve
WORKDIR /egosieve
RUN ./run setup && ./run install --portable --prefix=/opt/egosieve
RUN tools/embed/install/debian_packages /opt/egosieve/bin/egosieve >/opt/egosieve/packages

FROM debian:${DEBIAN}-slim
COPY --from=build /opt/egosieve /opt/egosieve
RUN apt-get update && \
    apt-get install -y --no-install-recommends $(cat /opt/egosieve/packages) pocl-opencl-icd && \
    rm -rf /var/lib/apt/lists/* && \
    useradd --create-home egosieve
ENV PATH=/opt/egosieve/bin:$PATH
USER egosieve
WORKDIR /home/egosieve
ENTRYPOINT ["egosieve"]
CMD ["--help"]
