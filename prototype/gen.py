import sys, json, time, traceback
sys.path.insert(0,'/tmp')
from conv import convert
from nonsmooth.proofs.many_states.many_certificate import build_many_certificate, _written
from nonsmooth.proofs.many_state_checker import check_certificate
from nonsmooth.proofs.many_states.decision import decide_many
from nonsmooth.proofs.systems.system_certificate import NoCertificateError
from nonsmooth.symbolic.files.system_file import build_system
sys.path.insert(0,'/work/clones/kernel')
from tests.proofs.many_states.test_known_systems import KNOWN
from pathlib import Path
import inspect
from tests.proofs.many_states import test_known_systems as T
src=inspect.getsource(T)
from checker.statements import refusal
for i,k in enumerate(KNOWN):
    data={"states":k.states.split(),"rhs":k.rhs}
    try:
        build={n:v for n,v in T.__dict__.items() if callable(v)}
        system=T._system(k) if hasattr(T,'_system') else T.build(k)
    except Exception as e:
        print(i,'system',e); continue
    try:
        r=decide_many(system); t0=time.time()
        old=_written(r); t1=time.time()
        a=check_certificate(old); t2=time.time()
        new=convert(old)
        size=len(json.dumps(new)); t3=time.time()
        b=refusal(new,size); t4=time.time()
        json.dump(new,open(f'/tmp/certs/many{i}.json','w'))
        print(i,r.verdict,repr(a),round(t2-t1,2),repr(b),round(t4-t3,2),size,flush=True)
    except NoCertificateError as e:
        print(i,r.verdict,'no:',str(e)[:90],flush=True)
    except Exception as e:
        traceback.print_exc(limit=-2)
