# docker build -t fsm-calib . && docker run --rm -v "$PWD/out:/work/out" fsm-calib run full_calibration
FROM python:3.11-slim
WORKDIR /source
COPY pyproject.toml setup.py README.md LICENSE ./
COPY fsm_calib fsm_calib
COPY scenarios scenarios
COPY diagrams diagrams
RUN python3 -m pip install --no-cache-dir . && fsm-calib warm
WORKDIR /work
ENTRYPOINT ["fsm-calib"]
CMD ["run", "full_calibration"]
